"""Lookup by name, with errors that list the existing names."""

from typing import Any, Callable, Collection, Iterator, Mapping, Optional, TypeVar, Union, overload

from flatland_server.exceptions import FlatlandError

T = TypeVar("T")
Default = TypeVar("Default")


class Catalog(Mapping[str, T]):
    """A read-only mapping that is always up to date.

    Args:
        names: the present names, in their order.
        make: returns the value for a present name.
        unknown: returns the error for any other name.
    """

    def __init__(
        self,
        names: Callable[[], Collection[str]],
        make: Callable[[str], T],
        unknown: Callable[[str], FlatlandError],
    ) -> None:
        self._names = names
        self._make = make
        self._unknown = unknown

    def __getitem__(self, name: str) -> T:
        """The value of this name.

        Raises:
            FlatlandError: there is no such name.
        """
        if name not in self._names():
            raise self._unknown(str(name))
        return self._make(name)

    def __contains__(self, name: object) -> bool:
        return name in self._names()

    def __iter__(self) -> Iterator[str]:
        return iter(list(self._names()))

    def __len__(self) -> int:
        return len(self._names())

    @overload
    def get(self, name: str) -> Optional[T]: ...

    @overload
    def get(self, name: str, default: Default) -> Union[T, Default]: ...

    def get(self, name: str, default: Any = None) -> Any:
        """The value of this name, or the default."""
        return self._make(name) if name in self._names() else default

    def __repr__(self) -> str:
        return f"{{{', '.join(self)}}}"
