"""Checks that rospy has the attributes and signatures that a patch relies on."""

import functools
import importlib
import inspect
from typing import Any, Iterable, NamedTuple, Optional, Tuple


class UnknownRospyError(Exception):
    """This rospy lacks something that a patch relies on."""


class Requirement(NamedTuple):
    """An attribute that must exist.

    Attributes:
        path: `module:attribute.attribute`.
        parameters: the names of a callable's parameters; None: not checked.
        uses: names that a function's code must use, for instance attributes that `__init__` sets.
    """

    path: str
    parameters: Optional[Tuple[str, ...]] = None
    uses: Tuple[str, ...] = ()

    def check(self) -> None:
        """Checks it.

        Raises:
            UnknownRospyError: it is not met.
        """
        target = self._resolve()
        if self.parameters is not None:
            found = tuple(inspect.signature(target).parameters)
            if found != self.parameters:
                raise UnknownRospyError(f"{self.path} has the parameters {', '.join(found)}")
        missing = [name for name in self.uses if name not in _names_used(target)]
        if missing:
            raise UnknownRospyError(f"{self.path} does not use {', '.join(missing)}")

    def _resolve(self) -> Any:
        module, _, attributes = self.path.partition(":")
        try:
            return functools.reduce(getattr, attributes.split("."), importlib.import_module(module))
        except (ImportError, AttributeError):
            raise UnknownRospyError(f"{self.path} is missing") from None


def check_all(requirements: Iterable[Requirement]) -> None:
    """Checks requirements.

    Raises:
        UnknownRospyError: one is not met; it names the first.
    """
    for requirement in requirements:
        requirement.check()


def _names_used(function: Any) -> Tuple[str, ...]:
    """The attribute names in a function's code."""
    code = getattr(inspect.unwrap(function), "__code__", None)
    return code.co_names if code is not None else ()
