"""Files of recorded messages: .bag, as `rosbag record` writes them, and .mcap, as Foxglove does.

Both contain the definitions of the message types, so that a reader needs nothing else.
"""

import os
import weakref
from abc import ABC, abstractmethod
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, Set, Tuple, Type, Union

from flatland_server.exceptions import RecordingError, listed

_INSTALL = 'pip install "flatland2d[record]"'


_in_use: Set[Path] = set()
"""The files that this process is writing."""


class RecordingFile(ABC):
    """A file that is being written, under its name with ".active" until it is closed.

    It is closed at the latest when it is garbage-collected or the program ends.

    Args:
        path: of the file; one of this name is replaced when this one is closed.

    Raises:
        RecordingError: the file cannot be written or is being recorded already, or a package is
            missing.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        with _errors_of(path):
            active = path.absolute().with_name(f"{path.name}.active")
            if active in _in_use:
                raise RecordingError(f"{path}: is being recorded already")
            active.unlink(missing_ok=True)  # left by a process that was killed
            finish = self._open(active)
        _in_use.add(active)
        self._end = weakref.finalize(self, _end, finish, active, path, os.getpid())

    def write(
        self, topic: str, message_type: Any, nanoseconds: int, data: bytes, is_latched: bool = False
    ) -> None:
        """Appends a message.

        Args:
            topic: its absolute name.
            message_type: the message's class.
            nanoseconds: the simulated time [ns].
            data: the serialized message.
            is_latched: whether a player repeats it to subscribers that come later.

        Raises:
            RecordingError: the file cannot be written.
        """
        with _errors_of(self.path):
            self._write(topic, message_type, nanoseconds, data, is_latched)

    def close(self) -> None:
        """Finishes the file."""
        self._end()

    @abstractmethod
    def _open(self, path: Path) -> Callable[[], None]:
        """Begins the file; returns the function that finishes it."""

    @abstractmethod
    def _write(
        self, topic: str, message_type: Any, nanoseconds: int, data: bytes, is_latched: bool
    ) -> None:
        """Appends a message."""


class BagFile(RecordingFile):
    """A .bag of ROS 1, version 2.0."""

    def _open(self, path: Path) -> Callable[[], None]:
        writer = _package("rosbags.rosbag1", ".bag").Writer
        self._writer = writer(path)
        self._writer.open()
        self._connections: Dict[Tuple[str, str], Any] = {}
        return self._writer.close  # type: ignore[no-any-return]

    def _write(
        self, topic: str, message_type: Any, nanoseconds: int, data: bytes, is_latched: bool
    ) -> None:
        key = (topic, message_type._type)
        if key not in self._connections:
            self._connections[key] = self._writer.add_connection(
                topic,
                message_type._type.replace("/", "/msg/"),  # as rosbags names types
                msgdef=message_type._full_text,
                md5sum=message_type._md5sum,
                callerid="/flatland_server",
                latching=int(is_latched),
            )
        # To rosbag, the time 0 means none: such a message would not be played.
        self._writer.write(self._connections[key], max(nanoseconds, 1), data)


class McapFile(RecordingFile):
    """An .mcap with the profile of ROS 1."""

    def _open(self, path: Path) -> Callable[[], None]:
        writer = _package("mcap.writer", ".mcap").Writer
        self._writer = writer(str(path))
        self._writer.start(profile="ros1", library="flatland")
        self._schemas: Dict[str, int] = {}
        self._channels: Dict[Tuple[str, str], int] = {}
        return self._writer.finish  # type: ignore[no-any-return]

    def _write(
        self, topic: str, message_type: Any, nanoseconds: int, data: bytes, is_latched: bool
    ) -> None:
        name = message_type._type
        if name not in self._schemas:
            definition = message_type._full_text.encode()
            self._schemas[name] = self._writer.register_schema(name, "ros1msg", definition)
        if (topic, name) not in self._channels:
            metadata = {
                "callerid": "/flatland_server",
                "latching": str(int(is_latched)),
                "md5sum": message_type._md5sum,
            }
            self._channels[topic, name] = self._writer.register_channel(
                topic, "ros1", self._schemas[name], metadata
            )
        self._writer.add_message(self._channels[topic, name], nanoseconds, data, nanoseconds)


_KINDS: Dict[str, Type[RecordingFile]] = {".bag": BagFile, ".mcap": McapFile}


def open_recording(path: Union[str, "os.PathLike[str]"]) -> RecordingFile:
    """Begins a recording in the format of the file's extension.

    Raises:
        RecordingError: the format is unknown, the file cannot be written, or a package is missing.
    """
    file = Path(path)
    kind = _KINDS.get(file.suffix.lower())
    if kind is None:
        raise RecordingError(f"{file}: expected a name that ends with {listed(_KINDS)}")
    return kind(file)


def _end(finish: Callable[[], None], active: Path, path: Path, process: int) -> None:
    """Finishes and renames a file; does nothing in a fork of the process that writes it."""
    if os.getpid() != process:
        return
    _in_use.discard(active)
    with _errors_of(path):
        finish()
        os.replace(active, path)


def _package(module: str, suffix: str) -> Any:
    """Imports a module that only recording needs, or says how to install it."""
    try:
        return import_module(module)
    except ImportError as error:
        package = module.partition(".")[0]
        raise RecordingError(
            f"a {suffix} recording needs the Python package {package} ({error}): {_INSTALL}, "
            f"or pip install {package}"
        ) from None


@contextmanager
def _errors_of(path: Path) -> Iterator[None]:
    """Turns errors of the operating system into those of a recording."""
    try:
        yield
    except OSError as error:
        raise RecordingError(f"{path}: cannot be written: {error.strerror or error}") from error
