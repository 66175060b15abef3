"""Checks of the arrays that a program passes to a batch."""

from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np

from flatland_server._core import Walls
from flatland_server.arguments import shown, whole_number
from flatland_server.arrays import BoolArray, FloatArray, IntArray
from flatland_server.exceptions import StateError, UsageError
from flatland_server.simulation import WorldState

MAX_COORDINATE = 5e4
"""The greatest distance of a pose from the origin along x and y [m]."""

_MAX_SEED = 2**63 - 1


def actions_of(value: Any, shape: Tuple[int, ...], names: Sequence[str]) -> FloatArray:
    """Actions out of an array of float32 or float64, or of nested lists of numbers.

    The core checks whether they are finite.

    Args:
        value: the array or nested list to convert.
        shape: shape that the array must have.
        names: names of the numbers of an action, for the error.

    Raises:
        UsageError: they have another shape or type.
    """
    array = _array(value, "actions", f"shape {shape}: {', '.join(names)}", shape)
    if array.dtype.kind not in "fiu":
        raise UsageError(f"expected actions of float32 or float64, found {array.dtype}")
    return np.ascontiguousarray(array, dtype=np.float64)


def poses_of(
    value: Any, name: str, rows: Tuple[int, ...], mask: Optional[BoolArray] = None
) -> FloatArray:
    """Poses, one after the other.

    Args:
        value: what a program has passed, of the shape (*rows, 3).
        name: name of the argument, for the error.
        rows: number of environments; perhaps that of robots or models in each.
        mask: which environments, or which of the poses, matter; None: all.

    Returns:
        Shape (number of poses, 3).

    Raises:
        UsageError: they have another shape or type, or one that matters is not finite.
    """
    shape = (*rows, 3)
    array = _array(value, name, f"shape {shape}: x, y, yaw", shape)
    if array.dtype.kind not in "fiu":
        raise UsageError(f"expected {name} of float64, found {array.dtype}")
    poses = np.ascontiguousarray(array, dtype=np.float64)
    is_right = np.abs(poses if mask is None else poses[mask]) <= MAX_COORDINATE  # False for NaN
    if not is_right.all():
        wrong = np.zeros(rows, bool)
        wrong[... if mask is None else mask] = ~is_right.all(axis=-1)
        place = tuple(np.argwhere(wrong)[0].tolist())
        number = f"number {place[1]} of " if len(place) > 1 else ""
        raise UsageError(
            f"expected {name} of finite numbers up to {MAX_COORDINATE:g}, found "
            f"{poses[place].tolist()} for {number}environment {place[0]}"
        )
    return poses.reshape(-1, 3)


def mask_of(value: Any, count: int, robots: Optional[int] = None) -> BoolArray:
    """A mask of environments, or of their robots: an array of bool.

    Args:
        value: the array or list to convert.
        count: number of environments, n.
        robots: number of robots, m, if the mask may have the shape (n, m), too.

    Raises:
        UsageError: it has another shape or type.
    """
    form = f"shape ({count},) of bool"
    shape: Tuple[int, ...] = (count,)
    if robots is not None:
        form = f"shape ({count},) or ({count}, {robots}) of bool"
        shape = (count, robots) if np.ndim(value) > 1 else shape
    array = _array(value, "a mask", form, shape)
    if array.dtype != bool:
        raise UsageError(f"expected a mask of bool, found {array.dtype}")
    return np.ascontiguousarray(array)


def seeds_of(value: Any, count: int) -> IntArray:
    """The seed of each environment, given the first one or all of them.

    Raises:
        UsageError: they are no whole numbers of 0 or more, or not as many as environments.
    """
    if np.ndim(value) == 0:
        first = whole_number(value, "a seed", 0)
        if first > _MAX_SEED - count:
            raise UsageError(f"expected a seed below 2^63 - {shown(count)}, found {shown(first)}")
        return np.arange(first, first + count)
    array = _array(value, "seeds", f"{count} whole numbers", (count,))
    if array.dtype.kind not in "iu" or (array < 0).any() or (array > _MAX_SEED).any():
        raise UsageError(f"expected seeds of 0 to 2^63 - 1, found {shown(array)}")
    return np.array(array, np.intp)


def walls_of(
    value: Mapping[int, Optional[Walls]], count: int, mask: Optional[BoolArray]
) -> Dict[int, Optional[Walls]]:
    """Walls of environments by their indices.

    Raises:
        UsageError: they are no dict of walls; or there is no such environment, or not in the mask.
    """
    if not isinstance(value, Mapping):
        raise UsageError(f"expected walls as a dict by environment, found {shown(value)}")
    for index, walls in value.items():
        require_index(index, count)
        if mask is not None and not mask[index]:
            raise UsageError(
                f"expected walls of environments that are reset, found those of {index}"
            )
        if not (walls is None or isinstance(walls, Walls)):
            raise UsageError(f"expected Walls for environment {index}, found {shown(walls)}")
    return dict(value)


def states_of(value: Any, count: int) -> List[bytes]:
    """The state of each chosen environment, given one for all or one for each.

    Raises:
        UsageError: they are no bytes, or not as many as environments are chosen.
    """
    if isinstance(value, bytes):
        return [value] * count
    if not isinstance(value, Sequence) or not all(isinstance(each, bytes) for each in value):
        raise UsageError(f"expected states as bytes, or a list of these, found {shown(value)}")
    if len(value) != count:
        raise UsageError(f"expected {count} states, found {len(value)}")
    return list(value)


def steps_of(state: WorldState, step_nanoseconds: int) -> int:
    """The number of steps that lead to the time of a state.

    Raises:
        StateError: it is between two steps, or no environment can have the state's seed.
    """
    if not 0 <= state.seed <= _MAX_SEED:
        raise StateError(f"expected a state with a seed of 0 to 2^63 - 1, found {state.seed}")
    steps, rest = divmod(state.nanoseconds, step_nanoseconds)
    if rest:
        raise StateError(
            f"expected a state after whole steps of {step_nanoseconds * 1e-9:g} s, found one at "
            f"{state.nanoseconds * 1e-9:g} s"
        )
    return steps


def _array(value: Any, what: str, form: str, shape: Tuple[int, ...]) -> Any:
    """A value as an array of a given shape.

    Raises:
        UsageError: it is no array of this shape.
    """
    try:
        array = np.asarray(value)
    except ValueError:  # lists of unequal lengths
        raise UsageError(f"expected {what} of {form}, found {shown(value)}") from None
    if array.shape != shape:
        raise UsageError(f"expected {what} of {form}, found shape {array.shape}")
    return array


def index_of(value: Any, count: int) -> BoolArray:
    """The mask that chooses one of n environments by its index.

    Raises:
        UsageError: there is no environment of this index.
    """
    require_index(value, count)
    mask: BoolArray = np.arange(count) == value
    return mask


def require_index(value: Any, count: int) -> None:
    """Raises a UsageError unless there is an environment of this index, of n."""
    is_whole = isinstance(value, (int, np.integer)) and not isinstance(value, bool)
    if not (is_whole and 0 <= value < count):
        raise UsageError(f"expected an environment from 0 to {count - 1}, found {shown(value)}")
