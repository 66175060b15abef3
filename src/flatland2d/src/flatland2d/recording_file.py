"""Files of recorded messages: .bag, as `rosbag record` writes them, and .mcap, as Foxglove does.

Both contain the definitions of the message types, so that a reader needs nothing else. Messages are
written in chunks, each of which can be read even if the file has no index yet.
"""

import contextlib
import errno
import fcntl
import mmap
import os
import threading
import weakref
from pathlib import Path
from typing import Dict, Iterator, Optional, Type, Union

from flatland2d.bag_format import BagFormat
from flatland2d.mcap_format import McapFormat
from flatland2d.recording_format import Channel, Damaged, Format, Recorded
from flatland_server.arguments import path_of
from flatland_server.config import open_regular, refusal_by, require_free
from flatland_server.exceptions import RecordingError, listed

CHUNK_SIZE = 1 << 20
"""The size at which a chunk is written [bytes]."""

CHUNK_TIME = 1.0
"""The real time after which a chunk is written, whatever its size [s]."""

UNFINISHED = ".active"
"""Ends the name of a file that is being written."""

_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)

_FORMATS: Dict[str, Type[Format]] = {".bag": BagFormat, ".mcap": McapFormat}


class RecordingFile:
    """A file that is being written, under another name until it is closed.

    It is closed at the latest when it is garbage-collected or the program ends. When the disk is
    full, it is closed, too, with all complete chunks for which there is room.

    Args:
        path: of the file, which ends with .bag or .mcap. When this one is closed, it replaces a
            recording of this name.
        unfinished: appended to the name until then.
        encoding: of the messages: ros1, or cdr, as ROS 2 has them.

    Raises:
        RecordingError: the format is unknown, or has no messages of this encoding; the file cannot
            be written, something else than a recording is there, or it is being recorded already.
    """

    def __init__(
        self,
        path: Union[str, "os.PathLike[str]"],
        unfinished: str = UNFINISHED,
        encoding: str = "ros1",
    ) -> None:
        self.path = path_of(path, "the path of a recording")
        kind = _FORMATS.get(self.path.suffix.lower())
        if kind is None or encoding not in kind.encodings:
            endings = [name for name, each in _FORMATS.items() if encoding in each.encodings]
            of_ros2 = " for messages of ROS 2" if encoding == "cdr" else ""
            raise RecordingError(
                f"{self.path}: expected a name that ends with {listed(endings)}{of_ros2}"
            )
        self._writer = _Writer(self.path, kind(encoding), unfinished)
        self._end = weakref.finalize(self, _close, self._writer, os.getpid())

    def write(self, channel: Channel, nanoseconds: int, data: bytes) -> None:
        """Appends a message.

        Args:
            channel: its topic and type.
            nanoseconds: the simulated time [ns].
            data: the serialized message.

        Raises:
            RecordingError: the disk is full, or the file is closed; it has ended before this
                message.
        """
        self._writer.write(Recorded(channel, nanoseconds, data))

    def close(self) -> None:
        """Finishes the file.

        Raises:
            RecordingError: not all that was recorded could be written.
        """
        self._end()


def read_recording(path: Path) -> Iterator[Recorded]:
    """The messages of a file that Flatland has written, finished or not: up to its last chunk.

    Raises:
        RecordingError: it cannot be read, or is no recording.
    """
    try:
        with open_regular(path, refusal_by(RecordingError)) as file, mmap.mmap(
            file.fileno(), 0, prot=mmap.PROT_READ
        ) as data:
            for kind in _FORMATS.values():
                if data[: len(kind.magic)] == kind.magic:
                    with contextlib.suppress(Damaged):
                        yield from kind.read(data)
                    return
    except ValueError:  # an empty file
        pass
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read: {error.strerror}") from None
    raise RecordingError(f"{path}: expected a recording, found something else")


class _Writer:
    """Writes chunks, at the latest in a thread of its own, which also finishes the file."""

    def __init__(self, path: Path, form: Format, unfinished: str) -> None:
        self._path = path
        self._active = path.absolute().with_name(path.name + unfinished)
        self._format = form
        self._lock = threading.Lock()  # of the format and the file
        self._is_ending = threading.Event()
        self._error: Optional[Exception] = None
        try:
            self._require_free(path)
            self._descriptor = self._begin()
        except (OSError, ValueError) as error:  # ValueError: the name contains a zero byte
            raise self._failure(error) from None
        self._thread = threading.Thread(target=self._run, name="recording", daemon=True)
        self._thread.start()

    def write(self, message: Recorded) -> None:
        with self._lock:
            if not self._is_ending.is_set():
                self._format.add(message)
                if self._format.size >= CHUNK_SIZE:
                    self._write_chunk()
        if self._is_ending.is_set():
            self.close()
            raise RecordingError(f"{self._path}: the recording is closed")

    def close(self) -> None:
        """Finishes the file, and raises the error that has ended it, once."""
        self._is_ending.set()
        if self._thread is threading.current_thread():  # by garbage collection; it ends next
            return
        self._thread.join()
        error, self._error = self._error, None
        if isinstance(error, OSError):
            end = max((chunk.end for chunk in self._format.chunks), default=0) * 1e-9
            raise self._failure(
                error,
                f"; `flatland recover {self._active}` reads what was"
                if self._active.exists()
                else f"; the recording is complete up to {end:.3f} s",
            )
        if error is not None:
            raise error

    def _begin(self) -> int:
        """Begins the file, in place of one that was left by a process that was killed."""
        self._require_free(self._active)
        with contextlib.suppress(FileNotFoundError):
            with self._active.open("rb") as former:
                self._reserve(former.fileno())
            self._active.unlink()
        descriptor = os.open(self._active, os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o666)
        try:
            self._reserve(descriptor)
            self._size = _write(descriptor, self._format.beginning(0), 0)
        except BaseException:
            os.close(descriptor)
            self._active.unlink()
            raise
        return descriptor

    def _run(self) -> None:
        while not self._is_ending.wait(CHUNK_TIME):
            with self._lock:
                if self._format.size:
                    self._write_chunk()
        with self._lock:
            try:
                self._finish()
            except (OSError, RecordingError) as error:
                self._error = self._error or error
            finally:
                os.close(self._descriptor)

    def _write_chunk(self) -> None:
        """Writes the open chunk; if that fails, the recording ends before it."""
        chunk = self._format.take_chunk(self._size)
        try:
            self._size += _write(self._descriptor, chunk, self._size)
        except OSError as error:
            self._format.drop_chunk()
            self._error = error
            self._is_ending.set()

    def _finish(self) -> None:
        """Writes the index, on a full disk in place of the last chunks, and renames the file."""
        if self._error is None and self._format.size:
            self._write_chunk()
        while True:
            index = self._format.index(self._size)
            try:
                end = self._size + _write(self._descriptor, index, self._size)
                break
            except OSError as error:
                self._error = self._error or error
                if error.errno not in _FULL or not self._format.chunks:
                    raise
                self._size = self._format.drop_chunk()
        os.ftruncate(self._descriptor, end)
        _write(self._descriptor, self._format.beginning(self._size), 0)
        complete = self._active.with_name(self._path.name)  # not of a folder entered since
        self._require_free(complete)
        os.replace(self._active, complete)

    def _require_free(self, path: Path) -> None:
        require_free(path, self._format.magic, "a recording of this format", RecordingError)

    def _reserve(self, descriptor: int) -> None:
        """Locks the file, as long as it is open."""
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise RecordingError(f"{self._path}: is being recorded already") from None
        except OSError:  # the file system has no locks
            pass

    def _failure(self, error: Exception, more: str = "") -> RecordingError:
        reason = error.strerror if isinstance(error, OSError) else error
        return RecordingError(f"{self._path}: cannot be written: {reason}{more}")


def _write(descriptor: int, data: bytes, position: int) -> int:
    """Writes all bytes at an offset in the file; returns their number."""
    written = 0
    while written < len(data):
        written += os.pwrite(descriptor, memoryview(data)[written:], position + written)
    return written


def _close(writer: _Writer, process: int) -> None:
    """Closes a file; does nothing in a fork of the process that writes it."""
    if os.getpid() == process:
        writer.close()
