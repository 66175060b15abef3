"""The worlds and models of this repository, copied to a folder where they may be spoilt."""

import shutil
from pathlib import Path
from typing import List

SRC = Path(__file__).resolve().parents[3]
FOLDERS = {
    "office": "flatland_server/worlds/office",
    "test_room": "flatland_server/worlds/test_room",
    "plugins": "flatland_plugins/test/worlds",
    "conveyor": "flatland_example_plugins/worlds/conveyor",
    "documentation": "flatland_server/test/files/documentation/examples",
}


class Corpus:
    """A folder of worlds, models, maps and parts of them that they include.

    Args:
        folder: where they are; see `copy_to`.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        files = sorted(path for path in folder.rglob("*") if path.is_file())
        self.originals = {path: path.read_bytes() for path in files}
        self.worlds = self._with_key(b"layers:")
        self.models = [path for path in self._with_key(b"bodies:") if path not in self.worlds]
        self.parts = [path for path in files if path not in self.worlds + self.models]

    @classmethod
    def copy_to(cls, folder: Path) -> "Corpus":
        """A new copy of the files of this repository."""
        for name, source in FOLDERS.items():
            shutil.copytree(SRC / source, folder / name, dirs_exist_ok=True)
        return cls(folder)

    def _with_key(self, key: bytes) -> List[Path]:
        """The YAML files with this key at the top."""
        return [
            path
            for path, content in self.originals.items()
            if path.suffix == ".yaml" and (content.startswith(key) or b"\n" + key in content)
        ]

    def restore(self, path: Path) -> None:
        """Undoes all changes of a file."""
        path.write_bytes(self.originals[path])
