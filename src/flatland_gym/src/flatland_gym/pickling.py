"""Environments that are pickled and copied by their arguments."""

import functools
from typing import Any, Mapping, Sequence, Tuple, Type, TypeVar

T = TypeVar("T")


class ByArguments:
    """An object of which pickles and copies are made anew, by the arguments of its constructor.

    As by Gymnasium's `EzPickle`, a live state is not copied: the copy has to be reset.
    """

    _made_with: Tuple[Sequence[Any], Mapping[str, Any]]

    def __new__(cls: Type[T], *arguments: Any, **named: Any) -> T:
        """Keeps the arguments, also those of a subclass's constructor."""
        made: T = super().__new__(cls)  # type: ignore[misc]
        made._made_with = arguments, named  # type: ignore[attr-defined]
        return made

    def __reduce__(self) -> Tuple[Any, ...]:
        arguments, named = self._made_with
        return functools.partial(type(self), **named), tuple(arguments)
