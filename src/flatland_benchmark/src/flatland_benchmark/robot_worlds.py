"""Worlds of many robots in the office, as the benchmark runs them.

Every robot has a drive, a transform publisher and a lidar of 1081 beams that scans at 10 Hz with or
without subscribers; everything else has its default rate, which is every step. The robots stand
still until they are commanded.
"""

from pathlib import Path
from typing import List

import numpy as np
import yaml

from flatland2d import DistanceGrid, FreeSpace, Pose, Simulation

RADIUS = 0.18
"""A robot's radius [m]."""

_CLEARANCE = 0.3
"""Of a robot's middle from walls [m]."""

_APART = 0.5
"""Least distance between robots' middles [m]."""

_START = (0.0, 0.0)
"""A point inside the walls: the office's lobby [m]."""

_TRIES = 1000
"""Places to draw for a robot."""


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
            "pose": list(pose),
        }
        for i, pose in enumerate(free_poses(floor(worlds, _CLEARANCE), robots))
    ]
    layers = [{"name": "map", "map": str(worlds / "office" / "office.yaml")}]
    path = folder / f"{robots}_robots.world.yaml"
    path.write_text(yaml.safe_dump({"properties": {}, "layers": layers, "models": models}))
    return path


def floor(worlds: Path, clearance: float) -> FreeSpace:
    """The places within the office's walls with a clearance from them [m]."""
    layers = [{"name": "map", "map": str(worlds / "office" / "office.yaml")}]
    with Simulation({"properties": {}, "layers": layers}) as sim:
        return DistanceGrid(sim.world.layers[0].segments, _START, clearance).free_space(clearance)


def free_poses(space: FreeSpace, count: int) -> List[Pose]:
    """Random poses of robots, all over a floor and clear of each other; always the same ones.

    Raises:
        ValueError: there are not that many.
    """
    rng = np.random.default_rng(0)
    drawn = space.clear_poses(rng, [], RADIUS, _APART - RADIUS, count, _TRIES)
    found = [pose for pose in drawn if pose is not None]
    if len(found) < count:
        raise ValueError(f"{count} robots do not fit, only {len(found)}")
    return found
