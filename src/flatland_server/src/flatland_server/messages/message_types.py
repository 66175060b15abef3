"""Message types by name: ROS's own classes where there is ROS, else our own.

    from flatland_server import messages

    LaserScan = messages.get("sensor_msgs/LaserScan")

So a plugin that never imports a ROS package runs with ROS and without.
"""

import importlib
from functools import cached_property
from pathlib import Path
from threading import RLock
from typing import Any, Callable, Dict, Iterator, List, Optional, Set, Tuple

from flatland_server.config.packages import python_package_folders
from flatland_server.exceptions import MessageError, shortened, suggestion
from flatland_server.messages import times
from flatland_server.messages.definition import (
    BUILT_IN,
    Definition,
    check_type_name,
    full_text,
    split_full_text,
)
from flatland_server.messages.field_forms import wire_form
from flatland_server.messages.message import Message, make_class
from flatland_server.messages.standard_definitions import standard_definitions
from flatland_server.messages.wire_form import Reader, WireForm

_DEFINITIONS = Path(__file__).parent / "definitions"
"""Folders of .msg files, by package: those of flatland_msgs."""


class MessageTypes:
    """The message types of a program.

    A type that ROS does not have is looked up among the common types of ROS, those of
    `flatland_msgs`, those added, and in the folder `msg` of the Python package that its name begins
    with: `my_plugins/Load` is in `my_plugins/msg/Load.msg`.

    Args:
        use_ros: whether to prefer ROS's own classes.
    """

    def __init__(self, use_ros: bool = True) -> None:
        self._use_ros = use_ros
        self._lock = RLock()
        self._added: Set[str] = set()
        self._definitions: Dict[str, Definition] = {}
        self._classes: Dict[str, Any] = {}
        self._wire_forms: Dict[str, WireForm] = {}

    @cached_property
    def _genpy(self) -> Any:
        """ROS's module, imported when it is needed: that takes 20 ms. None if there is no ROS."""
        try:
            return importlib.import_module("genpy") if self._use_ros else None
        except ImportError:
            return None

    @cached_property
    def Time(self) -> Callable[..., Any]:  # noqa: N802 (ROS's name)
        """The class of times in messages."""
        time_class: Callable[..., Any] = (self._genpy or times).Time
        return time_class

    @cached_property
    def Duration(self) -> Callable[..., Any]:  # noqa: N802 (ROS's name)
        """The class of durations in messages."""
        duration_class: Callable[..., Any] = (self._genpy or times).Duration
        return duration_class

    def get(self, name: str) -> Any:
        """The class of a message type.

        Args:
            name: such as `sensor_msgs/LaserScan`.

        Raises:
            MessageError: there is no such type.
        """
        cls = self._classes.get(name)
        if cls is not None:
            return cls
        if "/" not in str(name) and self._near_miss(str(name)):
            raise MessageError(f'there is no message type "{name}"{self._near_miss(name)}')
        check_type_name(name)
        with self._lock:
            if name not in self._classes:
                cls = self._ros_class(name)
                self._classes[name] = self._make(name) if cls is None else cls
            return self._classes[name]

    def add(self, name: str, definition: str) -> Any:
        """Adds a message type, and returns its class.

        Args:
            name: such as `my_plugins/Load`.
            definition: in ROS's .msg grammar, such as "float64 mass  # kg".

        Raises:
            MessageError: the definition is wrong, uses a type that does not exist, or there is
                another type of this name.
        """
        parsed = Definition.parse(name, definition)
        with self._lock:
            existing = self._existing_md5(name)
            if existing is None:
                self._definitions[name] = parsed
                self._added.add(name)
                try:
                    return self.get(name)
                except MessageError:
                    del self._definitions[name]
                    self._added.remove(name)
                    raise
            if existing != parsed.md5(self._md5):
                raise MessageError(f"there is a message type {name} already, with other fields")
            return self.get(name)

    def _existing_md5(self, name: str) -> Optional[str]:
        exists = self._ros_class(name) is not None or self._find(name) is not None
        return str(self.get(name)._md5sum) if exists else None

    def _ros_class(self, name: str) -> Any:
        """ROS's class; None if there is no ROS or its package is not there."""
        if self._genpy is None or name in self._added:
            return None
        return ros_class(name, "msg")

    def wire_form_of(self, message_type: Any) -> WireForm:
        """The wire form of a class, ROS's or ours.

        Args:
            message_type: the class, also of requests and responses of services.
        """
        name = message_type._type
        with self._lock:
            if name not in self._wire_forms:
                for used, text in split_full_text(name, message_type._full_text):
                    if used not in self._definitions:
                        self._definitions[used] = Definition.parse(used, text)
            return self._wire_form(name)

    def _make(self, name: str) -> Any:
        definition = self._definition(name)
        used = self._all_used(name)
        return make_class(
            definition,
            # rospy publishes only what is derived from genpy's.
            (Message, self._genpy.Message) if self._genpy else (Message,),
            self._factory,
            self._wire_form(name),
            restore,
            _md5sum=self._md5(name),
            _full_text=full_text(definition, map(self._definition, used)),
        )

    def _factory(self, kind: str) -> Any:
        if kind in BUILT_IN:
            return self.Time if kind == "time" else self.Duration
        return self.get(kind)

    def _wire_form(self, name: str) -> WireForm:
        with self._lock:
            if name not in self._wire_forms:
                self._wire_forms[name] = wire_form(
                    self._definition(name), self._definition, self._wire_form, self._factory
                )
            return self._wire_forms[name]

    def _md5(self, name: str) -> str:
        return self._definition(name).md5(self._md5)

    def _all_used(self, name: str, within: Tuple[str, ...] = ()) -> List[str]:
        """The types that a type uses, and those that they use, each once.

        Raises:
            MessageError: one of them does not exist, or contains itself.
        """
        if name in within:
            raise MessageError(f"the message type {name} contains itself")
        used: Dict[str, None] = {}
        for other in self._definition(name).uses:
            used[other] = None
            used.update(dict.fromkeys(self._all_used(other, (*within, name))))
        return list(used)

    def _definition(self, name: str) -> Definition:
        definition = self._find(name)
        if definition is None:
            raise MessageError(
                f'there is no message type "{shortened(name)}"{self._near_miss(name)}; '
                "messages.add(name, definition) adds one"
            )
        return definition

    def _find(self, name: str) -> Optional[Definition]:
        with self._lock:
            if name not in self._definitions:
                for found, text, source in self._sources(name):
                    self._definitions.setdefault(found, Definition.parse(found, text, source))
            return self._definitions.get(name)

    def _sources(self, name: str) -> Iterator[Tuple[str, str, str]]:
        """Names, texts and files of definitions in the first place that has one of the name."""
        cls = self._ros_class(name)
        if cls is not None:
            for used, text in split_full_text(name, cls._full_text):
                yield used, text, used
        elif name in standard_definitions():
            yield name, standard_definitions()[name], name
        else:
            for folder in _folders(name.partition("/")[0]):
                file = folder / f"{name.partition('/')[2]}.msg"
                if file.is_file():
                    yield name, file.read_text(encoding="utf-8"), str(file)
                    return

    def _near_miss(self, name: str) -> str:
        """A hint: a type of this name in another package, or one with a similar name."""
        known = {*self._added, *standard_definitions()}
        for package in ("flatland_msgs", name.partition("/")[0]):
            for folder in _folders(package):
                known.update(f"{package}/{file.stem}" for file in folder.glob("*.msg"))
        bare = name.rpartition("/")[2]
        for other in sorted(known):
            if other.partition("/")[2] == bare:
                return f' (did you mean "{other}"?)'
        return suggestion(name, sorted(known))


def _folders(package: str) -> List[Path]:
    """The folders that may have .msg files of a package."""
    if not package.isidentifier():
        return []
    folders = [path / "msg" for path in python_package_folders(package, with_namespaces=True)]
    return [folder for folder in (_DEFINITIONS / package, *folders) if folder.is_dir()]


def ros_class(name: str, folder: str) -> Any:
    """ROS's class of a message or service; None if there is none.

    Clients name types. A package is only imported if genpy has made this type for it: importing
    another could do anything.

    Args:
        name: name of the type, such as "sensor_msgs/LaserScan".
        folder: "msg" or "srv".
    """
    package, _, bare = name.partition("/")
    file = Path(folder, f"_{bare}.py")
    places = python_package_folders(package, with_namespaces=False) if bare.isidentifier() else []
    if not any((place / file).is_file() for place in places):
        return None
    try:
        cls = getattr(importlib.import_module(f"{package}.{folder}"), bare, None)
    except ImportError:
        return None
    return cls if getattr(cls, "_type", None) == name else None


TYPES = MessageTypes()

get = TYPES.get
add = TYPES.add


def deserialized(message_type: Any, data: bytes, errors: str = "surrogateescape") -> Any:
    """A message of bytes from outside, which ROS's own classes would believe.

    Args:
        message_type: class of the message: ROS's or ours.
        data: the serialized message.
        errors: as for `Reader`.

    Raises:
        MessageError: the data is too short for what it says to have, or means too many messages.
    """
    message = message_type()
    try:
        TYPES.wire_form_of(message_type).read(message, Reader(data, errors))
    except MessageError as error:
        raise MessageError(f"{message_type._type}: {error}") from None
    return message


def restore(name: str, *values: Any) -> Any:
    """A message of a type and the values of its fields: for pickle and copy."""
    return get(name)(*values)
