"""Opens the files that users name: regular files of a limited size, and nothing else.

A world may come from a stranger, and a path may be mistyped. A named pipe would block the simulator
until something is written to it, `/dev/zero` has no end, and the values of a file of a gigabyte
take ten.
"""

import errno
import os
import stat
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO, Callable, Iterator

from flatland_server.exceptions import FlatlandError, YamlError, nearest

MIB = 1024 * 1024
MAX_YAML = 16 * MIB  # bytes
MAX_LINE_SEGMENTS = 64 * MIB  # bytes: a million segments
MAX_IMAGE = 256 * MIB  # bytes
MAX_STATE = 64 * MIB  # bytes

Refusal = Callable[[Path, str], FlatlandError]
"""Makes the error of a file, from its path and the problem."""


def refusal_by(kind: Callable[[str], FlatlandError]) -> Refusal:
    """Refuses files by errors of another kind than YamlError.

    Args:
        kind: class of the errors.
    """
    return lambda path, problem: kind(f"{path}: {problem}")


def read_input(path: Path, limit: int, refusal: Refusal = YamlError) -> bytes:
    """The contents of a regular file.

    Args:
        path: path of the file; it may not exist, or be no regular file.
        limit: the largest size that is read [bytes].
        refusal: the error if it is missing, unreadable, larger, or not a regular file.

    Raises:
        FlatlandError: as `refusal` makes it.
    """
    try:
        with open_regular(path, refusal) as file:
            size = os.fstat(file.fileno()).st_size
            if size > limit:
                raise refusal(path, too_large(limit))
            content = file.read(size + 1)  # not `limit`: that much memory would be set aside
            if len(content) > size:  # it has grown, or has no size, like those in /proc
                content += file.read(limit + 1 - len(content))
    except (OSError, ValueError) as error:  # ValueError: the name contains a zero byte
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise refusal(path, f"cannot be read: {reason}") from None
    if len(content) > limit:
        raise refusal(path, too_large(limit))
    return content


def open_regular(path: Path, refusal: Refusal) -> BinaryIO:
    """Opens a regular file to read it; pipes, sockets and devices are refused at once.

    Args:
        path: path of the file; it may not exist, or be no regular file.
        refusal: makes the error for something else of a path and a message.

    Raises:
        OSError: it cannot be opened.
        FlatlandError: as `refusal` makes it.
    """
    # O_NONBLOCK: opening a named pipe would otherwise wait for its other end.
    flags = os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC | os.O_NOCTTY
    descriptor = os.open(path, flags)
    mode = os.fstat(descriptor).st_mode
    if stat.S_ISREG(mode):
        return open(descriptor, "rb")
    os.close(descriptor)
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
    raise refusal(path, "expected a regular file, found a pipe, a socket or a device")


def require_free(path: Path, magic: bytes, kind: str, refusal: Callable[[str], Exception]) -> None:
    """Checks that a file can be written: nothing is there, or a regular file of its own kind.

    Args:
        path: of the file; links are not followed.
        magic: the first bytes of such files.
        kind: their name, for the message.
        refusal: makes the error for something else of a path and a message.

    Raises:
        OSError: it cannot be looked at.
    """
    try:
        if stat.S_ISREG(path.lstat().st_mode):
            descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
            with open(descriptor, "rb") as file:
                if file.read(len(magic)) == magic:
                    return
    except FileNotFoundError:
        return
    raise refusal(f"{path}: expected a new file or {kind}, found something else")


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A context to write a file completely, or not at all.

    Its value is a path beside the file. What is written there replaces the file at the end, with
    its permissions and, if possible, its owner; it is deleted after an error.
    """
    partial = path.parent / f".{os.urandom(16).hex()}.partial"
    try:
        yield partial
        with suppress(FileNotFoundError):
            status = path.lstat()
            if stat.S_ISREG(status.st_mode):
                with suppress(PermissionError):
                    os.chown(partial, status.st_uid, status.st_gid)
                partial.chmod(stat.S_IMODE(status.st_mode))
        partial.replace(path)
    except BaseException:
        with suppress(OSError):
            partial.unlink()
        raise


def is_file(path: Path) -> bool:
    """True if there is such a regular file; False also for a name that is too long for a file."""
    try:
        return path.is_file()
    except OSError:
        return False


def why_not_a_file(path: Path) -> str:
    """The kind of a path that is no regular file, for messages, such as "is a folder"."""
    if os.path.isdir(path):
        return "is a folder"
    return "is not a regular file" if os.path.exists(path) else "is not there"


def similar_file(path: Path) -> str:
    """A hint at a file beside a path that is not there: of another case, or a similar name.

    An image may have the extension of another image, but not `.yaml`.
    """
    try:
        if path.exists():  # as a folder
            return ""
        names = [path.parent / name for name in sorted(os.listdir(path.parent))]
    except OSError:
        return ""
    names.sort(key=lambda each: each.suffix.lower() == path.suffix.lower())  # the last one counts
    stems = {each.stem: each.name for each in names if _is_yaml(each) == _is_yaml(path)}
    near = nearest(path.stem, stems)
    return "" if near is None else f' (did you mean "{stems[near]}"?)'


def _is_yaml(path: Path) -> bool:
    return path.suffix.lower() in (".yaml", ".yml")


def too_large(limit: int) -> str:
    """The problem of a file that is larger than a limit [bytes]."""
    return f"expected a file of at most {limit // MIB} MiB, found a larger one"
