"""Checks of the arguments that a program passes to a simulation."""

import math
import operator
import os
import sys
from numbers import Real
from pathlib import Path
from typing import Any, Dict, Iterable, List, Mapping, Sequence, TypeVar, Union

from flatland_server.exceptions import UsageError, shortened

T = TypeVar("T")


def whole_number(value: Any, what: str, minimum: int) -> int:
    """A whole number, such as a seed or a count of steps; also one of NumPy.

    Raises:
        UsageError: it is not a whole number, or below the minimum.
    """
    if type(value) is int and value >= minimum:
        return value
    try:
        number = operator.index(value)
    except TypeError:
        number = minimum - 1
    if number < minimum or isinstance(value, bool):
        raise UsageError(
            f"expected {what} that is a whole number of {minimum} or more, found {shown(value)}"
        )
    return number


def params_of(params: Any) -> Dict[str, Any]:
    """Parameters by name.

    Raises:
        UsageError: they are not a mapping with names as keys.
    """
    if not isinstance(params, Mapping) or not all(isinstance(name, str) for name in params):
        raise UsageError(f"expected params as a dict by name, found {shown(params)}")
    return dict(params)


def several(values: Iterable[T], what: str) -> List[T]:
    """The entries of a list argument; a single string is not a list.

    Raises:
        UsageError: it is not a list or another iterable.
    """
    if isinstance(values, (str, bytes)) or not isinstance(values, Iterable):
        raise UsageError(f"expected {what} as a list, found {shown(values)}")
    return list(values)


def path_of(value: Any, what: str) -> Path:
    """A path that a program has passed.

    Raises:
        UsageError: it is none.
    """
    try:
        return Path(value)
    except TypeError:
        raise UsageError(f"expected {what}, found {shown(value)}") from None


def folders_of(folders: Iterable[Union[str, "os.PathLike[str]"]]) -> List[Path]:
    """The argument `model_folders`.

    Raises:
        UsageError: it is not a list of paths.
    """
    what = "model_folders as paths"
    return [path_of(folder, what) for folder in several(folders, "model_folders")]


def finite(values: Sequence[Any], what: str) -> None:
    """Checks that all numbers among some values are finite.

    Raises:
        UsageError: one is not.
    """
    try:
        if math.isfinite(sum(values)):  # fast path: a finite sum has finite terms
            return
    except (TypeError, OverflowError):
        pass
    for value in values:
        try:
            is_finite = math.isfinite(value)
        except OverflowError:  # a whole number that is too large for a float
            is_finite = False
        except TypeError:
            continue  # not a number: left to the plugin to check
        if not is_finite:
            raise UsageError(f"expected {what} of finite numbers, found {shown(values)}")


def steps_in(duration: float, step_size: float, name: str) -> int:
    """The number of steps in a duration [s].

    Raises:
        UsageError: it is not a multiple of the steps, or shorter than one.
    """
    if not isinstance(duration, Real) or not abs(duration) <= sys.float_info.max:
        raise UsageError(f"expected {name} as a number of seconds, found {shown(duration)}")
    count = round(duration / step_size)
    if count < 1 or abs(count * step_size - duration) > 1e-6 * step_size * count:
        raise UsageError(
            f"expected {name} to be a multiple of the step_size of {step_size:g} s, "
            f"found {duration:g} s"
        )
    return count


def shown(value: Any) -> str:
    """A value for a message, on one line."""
    return shortened(repr(value))
