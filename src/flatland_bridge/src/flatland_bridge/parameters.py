"""Parameters that clients see and set: of a simulation, or of a ROS master."""

import threading
import xmlrpc.client
from abc import ABC, abstractmethod
from typing import Any, Dict, List, Mapping, Sequence
from xml.parsers.expat import ExpatError

from flatland_bridge.budget import ENTRY
from flatland_server.exceptions import FlatlandError, shortened

MOST_BYTES = 4_000_000
"""Bytes of the parameters that all clients have set: they stay when the clients leave."""

_MISSING = object()


class ParameterError(FlatlandError):
    """A client sets a value that no parameter can have, or too much; or a master is gone."""


class Parameters(ABC):
    """Values by absolute names, such as "/robot/speed". A value may be a dict of further ones.

    All methods may be called on any thread. They raise a ParameterError if a master is silent.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()  # of changes
        self._sizes: Dict[str, int] = {}  # of what clients have set

    @abstractmethod
    def get(self, name: str, default: Any = None) -> Any:
        """The value of a parameter, or the default if it is not set."""

    @abstractmethod
    def names(self) -> List[str]:
        """The names of all parameters with values other than dicts."""

    @abstractmethod
    def search(self, name: str) -> str:
        """The absolute name of a parameter that is set in the node's namespace or above it.

        As in ROS, the first part of the name decides, unless the name is absolute.

        Returns:
            An empty text if there is none.
        """

    def set(self, name: str, value: Any) -> None:
        """Sets a parameter.

        Args:
            name: absolute name of the parameter, such as "/use_sim_time".
            value: a value of a type that ROS's parameters can have.

        Raises:
            ParameterError: it is another one, or the clients have set too much.
        """
        size = ENTRY + _size_of(value)
        with self._lock:
            sizes = {**self._sizes_beside(name), name: size}
            if sum(sizes.values()) > MOST_BYTES:
                raise ParameterError(
                    f"{name}: expected at most {MOST_BYTES} bytes of parameters that clients set, "
                    "found more; delete_param makes room"
                )
            self._put(name, value)
            self._sizes = sizes

    def delete(self, name: str) -> None:
        """Deletes a parameter, and all below it; nothing happens if it is not set."""
        with self._lock:
            self._remove(name)
            self._sizes = self._sizes_beside(name)

    def _sizes_beside(self, name: str) -> Dict[str, int]:
        within = f"{name}/"
        return {key: size for key, size in self._sizes.items() if not f"{key}/".startswith(within)}

    @abstractmethod
    def _put(self, name: str, value: Any) -> None:
        """Sets a parameter."""

    @abstractmethod
    def _remove(self, name: str) -> None:
        """Deletes a parameter, if it is set."""


class LocalParameters(Parameters):
    """Parameters without ROS, which are read on other threads while they change.

    Args:
        values: initial values, by absolute name.
        node: the node with the namespace that is searched.
    """

    def __init__(self, values: Mapping[str, Any], node: str) -> None:
        super().__init__()
        self._node = node
        self._tree: Dict[str, Any] = {}  # is never changed, but replaced
        for name, value in values.items():
            self._put(name, value)

    def get(self, name: str, default: Any = None) -> Any:
        value: Any = self._tree
        for part in _parts(name):
            if not isinstance(value, dict) or part not in value:
                return default
            value = value[part]
        return value

    def names(self) -> List[str]:
        return _names_in(self._tree, "")

    def search(self, name: str) -> str:
        if name.startswith("/"):
            return name if self.get(name, _MISSING) is not _MISSING else ""
        for namespace in (self._node, ""):
            if self.get(f"{namespace}/{_parts(name)[0]}", _MISSING) is not _MISSING:
                return f"{namespace}/{name}"
        return ""

    def _put(self, name: str, value: Any) -> None:
        self._tree = _changed(self._tree, _parts(name), value)

    def _remove(self, name: str) -> None:
        if self.get(name, _MISSING) is not _MISSING:
            self._put(name, _MISSING)


def _parts(name: str) -> List[str]:
    return [part for part in name.split("/") if part]


def _names_in(tree: Mapping[str, Any], namespace: str) -> List[str]:
    found: List[str] = []
    for key, value in tree.items():
        name = f"{namespace}/{key}"
        found += _names_in(value, name) if isinstance(value, dict) else [name]
    return found


def _changed(tree: Mapping[str, Any], parts: Sequence[str], value: Any) -> Dict[str, Any]:
    """A tree with another value at a place; without that place if it is `_MISSING`."""
    first, *rest = parts
    if rest:
        below = tree.get(first)
        value = _changed(below if isinstance(below, dict) else {}, rest, value)
    changed = {key: each for key, each in tree.items() if key != first}
    return changed if value is _MISSING else {**changed, first: value}


def _size_of(value: Any) -> int:
    """Bytes of a value as a master gets it, which are roughly those in memory.

    Raises:
        ParameterError: XML-RPC has no such value: null, larger numbers, control characters.
    """
    try:
        text = xmlrpc.client.dumps((value,))
        if len(text) < MOST_BYTES:
            xmlrpc.client.loads(text)
    except (TypeError, OverflowError, ExpatError) as error:
        raise ParameterError(
            f"expected a value that a parameter of ROS can have: {shortened(str(error))}"
        ) from None
    return len(text)
