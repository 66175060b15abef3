"""Worlds of many robots in the office, as the benchmark runs them.

Every robot has a drive, a transform publisher and a lidar of 1081 beams that scans at 10 Hz with or
without subscribers; everything else has its default rate, which is every step. The robots stand
still until they are commanded.
"""

from pathlib import Path
from typing import List, Tuple

import numpy as np

from flatland_benchmark.free_space import read_free_space
from flatland_server import _core
from flatland_server.arrays import BoolArray

RADIUS = 0.18
"""A robot's radius [m]."""

_MODEL = f"""\
# The office's robot, with all plugins at their default rates.
bodies:
  - name: base_link
    type: dynamic
    footprints: [{{type: circle, radius: {RADIUS}, density: 38}}]
  - &wheel
    name: left_wheel
    pose: [0, 0.115, 0]
    type: dynamic
    footprints:
      - type: polygon
        points: [[-0.033, -0.01], [0.033, -0.01], [0.033, 0.01], [-0.033, 0.01]]
        layers: []
        density: 38
  - <<: *wheel
    name: right_wheel
    pose: [0, -0.115, 0]
joints:
  - type: weld
    name: left_wheel_weld
    bodies: [{{name: left_wheel, anchor: [0, 0]}}, {{name: base_link, anchor: [0, 0.115]}}]
  - type: weld
    name: right_wheel_weld
    bodies: [{{name: right_wheel, anchor: [0, 0]}}, {{name: base_link, anchor: [0, -0.115]}}]
plugins:
  - {{type: DiffDrive, name: diff_drive, body: base_link, odom_frame_id: ~odom}}
  - {{type: ModelTfPublisher, name: tf_publisher}}
  - type: Laser
    name: laser
    body: base_link
    origin: [0.05, 0, 0]
    range: 20
    angle: {{min: -2.356194490192345, max: 2.356194490192345, increment: 0.004363323129985824}}
    update_rate: 10
    always_publish: true
"""

_CELL = 0.25
"""Side of the cells of the search for free places [m]."""

_CLOSEST = 2
"""Least distance between robots in cells: 0.5 m."""

_START = (0.0, 0.0)
"""A point inside the walls: the office's lobby [m]."""


def write_world(folder: Path, worlds: Path, robots: int, *, crowded: bool = False) -> Path:
    """Writes a world of this many robots into a folder, and its model file.

    Args:
        folder: where the files go.
        worlds: the folder of flatland_server's worlds.
        robots: how many; robot `robot_7` has the namespace `robot_7`.
        crowded: whether they begin close together in the lobby, instead of all over the office.

    Returns:
        The world file.

    Raises:
        ValueError: the office has not got that many free places.
    """
    (folder / "robot.model.yaml").write_text(_MODEL)
    lines = [
        "properties: {}",
        f"layers: [{{name: map, map: {worlds / 'office' / 'office.yaml'}}}]",
        "models:" if robots else "models: []",
    ]
    for i, (x, y) in enumerate(free_places(worlds / "office" / "office.yaml", robots, crowded)):
        yaw = i * 2.4 % 6.28  # spread over all headings
        lines.append(
            f"  - {{name: robot_{i}, namespace: robot_{i}, model: robot.model.yaml, "
            f"pose: [{x:.3f}, {y:.3f}, {yaw:.3f}]}}"
        )
    path = folder / f"{robots}_robots.world.yaml"
    path.write_text("\n".join(lines) + "\n")
    return path


def free_places(map_file: Path, count: int, crowded: bool = False) -> List[Tuple[float, float]]:
    """Places [m] all over a map, within its walls and clear of them and of each other.

    Args:
        map_file: of an image map with an origin that is not rotated.
        count: how many.
        crowded: whether to choose those that are nearest to the lobby, as close as they may be.

    Raises:
        ValueError: there are not that many.
    """
    pixels, resolution, origin = read_free_space(map_file)
    cells = _coarsened(pixels, round(_CELL / resolution))
    column, row = ((np.array(_START) - origin) / _CELL).astype(int)
    roomy = _eroded(_core.connected(cells, (row, column)))
    widest = _CLOSEST if crowded else min(roomy.shape)
    for pitch in range(widest, _CLOSEST - 1, -1):
        rows, columns = np.nonzero(roomy[pitch // 2 :: pitch, pitch // 2 :: pitch])
        if len(rows) >= count:
            break
    else:
        raise ValueError(f"{map_file}: {count} robots do not fit, only {len(rows)}")
    cells_of_places = np.stack([columns, rows], axis=1) * pitch + pitch // 2
    places = (cells_of_places + 0.5) * _CELL + origin
    if crowded:
        chosen = np.argsort(np.linalg.norm(places - _START, axis=1), kind="stable")[:count]
    else:
        chosen = np.linspace(0, len(rows) - 1, count).round().astype(int)
    return [(float(x), float(y)) for x, y in places[chosen]]


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
