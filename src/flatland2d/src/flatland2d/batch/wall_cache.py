"""The visible walls that the scans of a batch have found, in files for later batches.

Scans are the same without them, only slower. So everything that goes wrong with a file is ignored.
"""

import contextlib
import hashlib
import os
import weakref
from functools import lru_cache
from pathlib import Path
from typing import List, Sequence

from flatland_server import _core
from flatland_server.arrays import Segments
from flatland_server.config.input_files import read_input, replacing
from flatland_server.exceptions import FlatlandError

_MOST_WALLS = 100_000
"""Of a layer; hashing more takes long."""
_LARGEST_FILE = 2**26
_MOST_BYTES = 2**28
"""Of all files together: the oldest ones are deleted."""


class WallCache:
    """The visible walls of some layers, and their files.

    The files are in `flatland2d/visible_walls` below `$XDG_CACHE_HOME`, or `~/.cache`. Their names
    are hashes of the walls and of the core; each begins with the hash of the rest.

    What scans have found is written when the batch is closed or freed, or when the program ends.

    Args:
        layers: the walls of each layer.
    """

    def __init__(self, layers: Sequence[Segments]) -> None:
        files: List[_File] = []
        for segments in layers:
            if len(segments) > _MOST_WALLS:
                continue
            walls = _core.VisibleWalls(segments)
            if walls.cell_count == 0:
                continue
            file = _File(walls, segments)
            if walls.filed_count < 0:  # all batches of the process share them
                file.load()
            files.append(file)
        self._save = weakref.finalize(self, _save, files)

    def save(self) -> None:
        """Writes what has been found, once."""
        self._save()


def _save(files: Sequence["_File"]) -> None:
    for file in files:
        file.save()


class _File:
    """A file with what is known of the walls of a layer."""

    def __init__(self, walls: _core.VisibleWalls, segments: Segments) -> None:
        self._walls = walls
        self._segments = segments

    @property
    def _path(self) -> Path:
        name = hashlib.sha256(_core_hash() + self._segments.tobytes()).hexdigest()
        return _folder() / name

    def load(self) -> None:
        """Takes the file's walls, if there is one; a damaged one is to be replaced."""
        self._walls.filed_count = 0
        try:
            path = self._path
            content = read_input(path, _LARGEST_FILE)
            os.utime(path)
        except (OSError, RuntimeError, FlatlandError):  # RuntimeError: there is no home folder
            return
        known = content[32:]
        if hashlib.sha256(known).digest() == content[:32] and self._walls.take(known):
            self._walls.filed_count = self._walls.found_count

    def save(self) -> None:
        """Writes all that is known, if that is more than the file has."""
        count = self._walls.found_count
        if count <= self._walls.filed_count:
            return
        known = self._walls.known()
        with contextlib.suppress(OSError, RuntimeError):
            path = self._path
            path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
            with replacing(path) as partial:
                partial.write_bytes(hashlib.sha256(known).digest() + known)
            self._walls.filed_count = count
            _delete_oldest(path.parent)


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
    for path in sorted(folder.iterdir(), key=lambda each: -each.stat().st_mtime):
        total += path.stat().st_size
        if total > _MOST_BYTES:
            path.unlink()
