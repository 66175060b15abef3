"""Reads the worlds of BARN, the Benchmark for Autonomous Robot Navigation, into ours.

BARN has 300 worlds of cylinders for Gazebo, each with the path that its authors computed on the
grid of 0.15 m that the cylinders stand on (D. Perille et al., "Benchmarking Metric Ground
Navigation", 2020). Its challenge drives a Jackal through them: start, goal, limits and score are
those of the challenge's run.py.
"""

import os
import re
from pathlib import Path
from typing import Any, Dict, List, NamedTuple
from xml.etree import ElementTree

import numpy as np
import yaml

from flatland_server.arrays import FloatArray, npy_array
from flatland_server.config import MAX_IMAGE, MAX_YAML, read_input, refusal_by, replacing
from flatland_server.exceptions import FlatlandError, listed

START = (-2.25, 3.0, 1.57)  # m, m, rad
GOAL = (START[0], START[1] + 10.0)  # m
_CELL = 0.15  # m
_REFUSAL = refusal_by(FlatlandError)
_FARTHEST, _SMALLEST = 1000.0, 0.001  # cylinders from the origin, and radii [m]
_CORNER = (-0.075 - 30 * _CELL, 0.075 + 5.0)  # of the grid's first cell [m]

_ROBOT = """\
# The Jackal of BARN: the footprint of its configuration of move_base, a lidar as Hokuyo's UST-10
bodies:
  - name: base
    footprints:
      - type: polygon
        points: [[-0.21, -0.165], [0.21, -0.165], [0.21, 0.165], [-0.21, 0.165]]
        density: 100
plugins:
  - type: DiffDrive
    name: drive
    body: base
    odom_frame_id: odom
    pub_rate: 20
  - type: Laser
    name: laser
    body: base
    range: 10
    angle: {min: -2.356, max: 2.356, increment: 0.00655}
    update_rate: 20
"""

_RULES = "# The worlds of BARN by the rules of its challenge: 1 m from the goal within 100 s\n"
_SETTINGS = {
    "controllers": [
        {"name": name, "call": f"flatland2d.sweep.drivers:{name}"} for name in ("gaps", "planner")
    ],
    "group": "BARN",
    "goal": list(GOAL),
    "goal_radius": 1.0,
    "time_limit": 100.0,
    "top_speed": 2.0,
}


class BarnWorld(NamedTuple):
    """A world of BARN.

    Attributes:
        number: 0 to 299 in the published set.
        cylinders: x, y, radius of each [m]: shape (n, 3).
        shortest_path: length of its shortest path from start to goal [m].
    """

    number: int
    cylinders: FloatArray
    shortest_path: float


def read_barn(folder: Path) -> List[BarnWorld]:
    """The worlds in a folder, by number: its world_N.world with their path_N.npy.

    Of several files of a number, such as those of DynaBARN, that near the path is the world.

    Raises:
        FlatlandError: there is none, or a file is missing or wrong.
    """
    worlds = _numbered(folder, "world_*.world")
    paths = {number: files[0] for number, files in _numbered(folder, "path_*.npy").items()}
    if not worlds:
        raise FlatlandError(f"{folder}: expected worlds of BARN (world_0.world ...), found none")
    missing = [f"path_{number}.npy" for number in worlds if number not in paths]
    if missing:
        raise FlatlandError(f"{folder}: found no {listed(missing)}")
    return [
        BarnWorld(number, _cylinders(_nearest(files, paths[number])), _path_length(paths[number]))
        for number, files in sorted(worlds.items())
    ]


def write_barn(worlds: List[BarnWorld], folder: Path) -> None:
    """Writes worlds of BARN as ours, with a robot, and a scenario file of all of them.

    Args:
        worlds: see `read_barn`.
        folder: made if it does not exist: scenarios.yaml, robot.model.yaml, and for each world
            world_N.yaml and world_N.model.yaml.

    Raises:
        FlatlandError: a file cannot be written, or there is another one of its name.
    """
    entries = [
        {"world": f"world_{world.number}.yaml", "shortest_path": round(world.shortest_path, 3)}
        for world in worlds
    ]
    content = {"worlds": entries, **_SETTINGS}
    files = {"scenarios.yaml": f"{_RULES}{_dump(content)}", "robot.model.yaml": _ROBOT}
    robot = {"name": "robot", "model": "robot.model.yaml", "pose": list(START)}
    for world in worlds:
        name = f"world_{world.number}"
        footprints = [
            {"type": "circle", "center": [x, y], "radius": radius, "density": 1}
            for x, y, radius in np.round(world.cylinders, 6).tolist()
        ]
        body = {"name": "cylinders", "type": "static", "footprints": footprints}
        cylinders = {"name": "cylinders", "model": f"{name}.model.yaml"}
        files[f"{name}.model.yaml"] = _dump({"bodies": [body]})
        files[f"{name}.yaml"] = _dump(
            {"properties": {}, "layers": [{"name": "walls"}], "models": [robot, cylinders]}
        )
    there = [name for name in files if os.path.lexists(folder / name)]
    for name in there:
        if read_input(folder / name, MAX_IMAGE, _REFUSAL) != files[name].encode():
            raise FlatlandError(
                f"{folder / name}: expected a new file, found one with other content: delete it, "
                "or choose another folder by --out"
            )
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name in files.keys() - there:
            with replacing(folder / name) as temporary:
                temporary.write_text(files[name])
    except OSError as error:
        raise FlatlandError(f"{folder}: cannot be written: {error.strerror}") from None


def _numbered(folder: Path, pattern: str) -> Dict[int, List[Path]]:
    """The files of a pattern with a number in the place of its star, by that number."""
    found: Dict[int, List[Path]] = {}
    for path in sorted(folder.rglob(pattern)):
        match = re.fullmatch(r"[a-z]+_(\d+)", path.stem)
        if match:
            found.setdefault(int(match[1]), []).append(path)
    return found


def _nearest(files: List[Path], other: Path) -> Path:
    """The file that has most folders in common with another one."""
    return max(files, key=lambda path: len(Path(os.path.commonpath([path, other])).parts))


def _cylinders(path: Path) -> FloatArray:
    """The cylinders of a world: x, y, radius [m].

    Raises:
        FlatlandError: the file cannot be read, or has no cylinders, or is no world.
    """
    try:
        root = ElementTree.fromstring(read_input(path, MAX_YAML, _REFUSAL))
        found = [
            (*map(float, model.findtext("pose", "").split()[:2]), float(radius.text or ""))
            for model in root.iter("model")
            for radius in model.iterfind("link/collision/geometry/cylinder/radius")
        ]
        cylinders = np.array(found, np.float64).reshape(-1, 3)
    except (ElementTree.ParseError, ValueError) as error:
        raise FlatlandError(f"{path}: expected a world of BARN: {error}") from None
    if not len(cylinders):
        raise FlatlandError(f"{path}: expected cylinders, found none")
    for x, y, radius in cylinders.tolist():
        if not (max(abs(x), abs(y), radius) <= _FARTHEST and radius >= _SMALLEST):
            raise FlatlandError(
                f"{path}: expected cylinders of {_SMALLEST} m or more within {_FARTHEST:g} m of "
                f"the origin, found one of radius {radius} at {x}, {y}"
            )
    return cylinders


def _path_length(path: Path) -> float:
    """The length of a path from start to goal over the cells of a file [m].

    Raises:
        FlatlandError: the file cannot be read, or has no cells.
    """
    try:
        cells = npy_array(read_input(path, MAX_YAML, _REFUSAL))
        corners = np.concatenate([[START[:2]], cells * _CELL + _CORNER, [GOAL]])
        if not (np.abs(corners) <= _FARTHEST).all():
            raise ValueError(f"found one farther than {_FARTHEST:g} m from the origin")
        return float(np.hypot(*np.diff(corners, axis=0).T).sum())
    except (ValueError, TypeError) as error:
        raise FlatlandError(f"{path}: expected columns and rows of cells: {error}") from None


def _dump(content: Any) -> str:
    dumper = getattr(yaml, "CSafeDumper", yaml.SafeDumper)
    text: str = yaml.dump(content, None, dumper, sort_keys=False, width=100)
    return text
