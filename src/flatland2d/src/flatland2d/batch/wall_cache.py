"""Visible walls for batches: found when a large batch is made, and kept in files for later ones.

Scans are the same without them, only slower. So everything that goes wrong with a file is ignored.
"""

import contextlib
import hashlib
import os
import tempfile
from functools import lru_cache
from pathlib import Path
from typing import Any, Iterator, List, Sequence

from flatland_server import _core
from flatland_server.arrays import Segments

_LARGE = 256
"""With fewer environments, walls are found where many scans are made."""
_MOST_CELLS = 4096
"""Larger maps are left to the scans: finding all their walls would take minutes."""
_MOST_WALLS = 100_000
"""Of a layer; hashing more takes long."""
_AT_ONCE = 64
"""Cells between two updates of the progress bar."""
_LARGEST_FILE = 2**26
_MOST_BYTES = 2**28
"""Of all files together: the oldest ones are deleted."""


class WallCache:
    """The visible walls of some layers, and their files.

    The files are in `flatland2d/visible_walls` below `$XDG_CACHE_HOME`, or `~/.cache`. Their names
    are hashes of the walls and of the core; each begins with the hash of the rest.

    Args:
        layers: the walls of each layer.
        count: the number of environments.
    """

    def __init__(self, layers: Sequence[Segments], count: int) -> None:
        self._files: List[_File] = []
        for segments in layers:
            if len(segments) > _MOST_WALLS:
                continue
            walls = _core.VisibleWalls(segments)
            if walls.cell_count == 0:
                continue
            file = _File(walls, hashlib.sha256(_core_hash() + segments.tobytes()).hexdigest())
            self._files.append(file)
            if not file.load() and count >= _LARGE and walls.cell_count <= _MOST_CELLS:
                _find(walls)
                file.write()

    def save(self) -> None:
        """Writes what has been found since then."""
        for file in self._files:
            if file.is_old:
                file.write()


class _File:
    """A file with what is known of the walls of a layer."""

    def __init__(self, walls: _core.VisibleWalls, name: str) -> None:
        self._walls = walls
        self._name = name
        self._size = len(walls.known())  # when the file was read or written

    def load(self) -> bool:
        """Takes the file's walls; returns False if it is damaged, or there is none."""
        try:
            path = _folder() / self._name
            content = path.read_bytes() if path.stat().st_size <= _LARGEST_FILE else b""
            os.utime(path)
        except (OSError, RuntimeError):  # there is no home folder
            return False
        known = content[32:]
        if hashlib.sha256(known).digest() != content[:32] or not self._walls.take(known):
            return False
        self._size = len(known)
        return True

    @property
    def is_old(self) -> bool:
        """True if more is known since it was read or written."""
        return len(self._walls.known()) > self._size

    def write(self) -> None:
        """Writes all that is known."""
        known = self._walls.known()
        self._size = len(known)
        with contextlib.suppress(OSError, RuntimeError):
            folder = _folder()
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            with tempfile.NamedTemporaryFile(dir=folder, delete=False) as file:
                file.write(hashlib.sha256(known).digest() + known)
            os.replace(file.name, folder / self._name)
            _delete_oldest(folder)


def _find(walls: _core.VisibleWalls) -> None:
    """Finds all, with a progress bar on a terminal if it takes over a second."""
    steps: Any = range(0, walls.cell_count, _AT_ONCE)
    with contextlib.suppress(ImportError):
        import tqdm

        steps = tqdm.tqdm(steps, "visible walls", delay=1.0, leave=False, disable=None)
    for begin in steps:
        walls.find(begin, min(begin + _AT_ONCE, walls.cell_count))


def _folder() -> Path:
    base = Path(os.environ.get("XDG_CACHE_HOME", ""))
    return (base if base.is_absolute() else Path.home() / ".cache") / "flatland2d/visible_walls"


@lru_cache(maxsize=1)
def _core_hash() -> bytes:
    """The hash of the core, as another one may find other walls."""
    return hashlib.sha256(Path(_core.__file__).read_bytes()).digest()


def _delete_oldest(folder: Path) -> None:
    """Deletes the files that were used least recently, beyond the limit of all."""
    total = 0
    for path, size in _newest_first(folder):
        total += size
        if total > _MOST_BYTES:
            path.unlink()


def _newest_first(folder: Path) -> Iterator[Any]:
    found = [(path, path.stat()) for path in folder.iterdir()]
    for path, status in sorted(found, key=lambda each: -each[1].st_mtime):
        yield path, status.st_size
