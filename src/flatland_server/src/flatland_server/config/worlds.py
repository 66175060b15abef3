"""The worlds that come with Flatland, by name: "office", "test_room".

They are found beside the package that is running: in a source tree, in an install space of catkin,
and in the package itself if pip has installed it.
"""

from pathlib import Path
from typing import Dict, Union

from flatland_server.config.file_names import to_path
from flatland_server.config.input_files import is_file
from flatland_server.config.packages import folders_beside
from flatland_server.exceptions import FlatlandError, unknown
from flatland_server.geometry import Point

SCENE_GOALS: Dict[str, Point] = {
    "corridor_frontal": (6.0, 0.0),
    "intersection": (6.0, 0.0),
    "doorway": (4.0, 0.0),
    "overtaking": (6.0, 0.0),
    "crossing": (5.0, 0.0),
    "circle_crossing": (-4.0, 0.0),
}
"""The goals [m] of the robots in the shipped scenes, by the worlds' names."""

_PACKAGE = Path(__file__).resolve().parents[1]
_SUFFIXES = (".yaml", ".yml")


def shipped_worlds() -> Dict[str, Path]:
    """The worlds' files by the worlds' names, sorted."""
    worlds: Dict[str, Path] = {}
    for folder in folders_beside(_PACKAGE.name, [_PACKAGE]):
        for file in folder.glob("worlds/*/world.yaml"):
            worlds.setdefault(file.parent.name, file)
    return dict(sorted(worlds.items()))


def is_shipped(path: Path) -> bool:
    """True for the file of a shipped world, by any of its names."""
    return path.resolve() in [each.resolve() for each in shipped_worlds().values()]


def find_world(name: Union[str, Path]) -> Path:
    """The file of a world.

    Args:
        name: of a shipped world; or a path, or a `package://` URI.

    Returns:
        The world's file; for a path, whether it exists or not.

    Raises:
        FlatlandError: a name that is no path is neither a shipped world nor a file; or there is no
            such package.
    """
    path = to_path(name)
    if isinstance(name, Path) or "/" in name or path.suffix in _SUFFIXES or is_file(path):
        return path
    worlds = shipped_worlds()
    if name not in worlds:
        problem = unknown("no world is named", name, worlds)
        raise FlatlandError(f"{problem}, and any file by its path")
    return worlds[name]
