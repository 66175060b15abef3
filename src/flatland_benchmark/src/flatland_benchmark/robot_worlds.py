"""Worlds of many robots in the office, as the benchmark runs them.

Every robot has a drive, a transform publisher and a lidar of 1081 beams that scans at 10 Hz with or
without subscribers; everything else has its default rate, which is every step. The robots stand
still until they are commanded.
"""

from pathlib import Path
from typing import List, Tuple

import numpy as np
import yaml

from flatland_benchmark.free_space import read_free_space
from flatland_server import _core
from flatland_server.arrays import BoolArray

RADIUS = 0.18
"""A robot's radius [m]."""

_CELL = 0.25
"""Side of the cells of the search for free places [m]."""

_CLOSEST = 2
"""Least distance between robots in cells: 0.5 m."""

_START = (0.0, 0.0)
"""A point inside the walls: the office's lobby [m]."""


def write_world(folder: Path, worlds: Path, robots: int) -> Path:
    """Writes a world of this many robots all over the office into a folder, and its model file.

    Args:
        folder: folder to write the files to.
        worlds: the folder of flatland_server's worlds.
        robots: how many; robot `robot_7` has the namespace `robot_7`.

    Returns:
        The world file.

    Raises:
        ValueError: the office has not got that many free places.
    """
    model = yaml.safe_load((worlds / "office" / "turtlebot.model.yaml").read_text())
    model["plugins"] = [each for each in model["plugins"] if each["type"] != "Bumper"]
    for plugin in model["plugins"]:
        if plugin["type"] == "Laser":
            plugin["always_publish"] = True
        else:
            plugin.pop("update_rate", plugin.pop("pub_rate", None))
    (folder / "robot.model.yaml").write_text(yaml.safe_dump(model))
    models = [
        {
            "name": f"robot_{i}",
            "namespace": f"robot_{i}",
            "model": "robot.model.yaml",
            "pose": [x, y, i * 2.4 % 6.28],  # spread over all headings
        }
        for i, (x, y) in enumerate(free_places(worlds / "office" / "office.yaml", robots))
    ]
    layers = [{"name": "map", "map": str(worlds / "office" / "office.yaml")}]
    path = folder / f"{robots}_robots.world.yaml"
    path.write_text(yaml.safe_dump({"properties": {}, "layers": layers, "models": models}))
    return path


def free_places(map_file: Path, count: int) -> List[Tuple[float, float]]:
    """Places [m] all over a map, within its walls and clear of them and of each other.

    Args:
        map_file: of an image map with an origin that is not rotated.
        count: number of places.

    Raises:
        ValueError: there are not that many.
    """
    pixels, resolution, origin = read_free_space(map_file)
    cells = _coarsened(pixels, round(_CELL / resolution))
    column, row = ((np.array(_START) - origin) / _CELL).astype(int)
    roomy = _eroded(_core.connected(cells, (row, column)))
    for pitch in range(min(roomy.shape), _CLOSEST - 1, -1):
        rows, columns = np.nonzero(roomy[pitch // 2 :: pitch, pitch // 2 :: pitch])
        if len(rows) >= count:
            break
    else:
        raise ValueError(f"{map_file}: {count} robots do not fit, only {len(rows)}")
    chosen = np.linspace(0, len(rows) - 1, count).round().astype(int)
    cells_of_places = np.stack([columns, rows], axis=1)[chosen] * pitch + pitch // 2
    return [(float(x), float(y)) for x, y in (cells_of_places + 0.5) * _CELL + origin]


def _coarsened(free: BoolArray, side: int) -> BoolArray:
    """True where a square of `side` x `side` pixels is entirely free."""
    height, width = (length // side for length in free.shape)
    squares = free[: height * side, : width * side].reshape(height, side, width, side)
    coarse: BoolArray = squares.all(axis=(1, 3))
    return coarse


def _eroded(free: BoolArray) -> BoolArray:
    """True where a cell and its eight neighbours are free."""
    padded = np.pad(free, 1)
    height, width = free.shape
    roomy = free.copy()
    for row in range(3):
        for column in range(3):
            roomy &= padded[row : row + height, column : column + width]
    return roomy
