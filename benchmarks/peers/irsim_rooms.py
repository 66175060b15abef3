"""The room in ir-sim and irsim-x, which share the name and the interface of their package."""

import inspect
import math
import tempfile
from typing import Any, Dict

import irsim
import numpy as np
import yaml

import scenario
from scenario import Scenario


class Room:
    """Robots in one world.

    Args:
        layout: the scenario.
        collisions: the world's `collision_mode`; "stop" is the default of both packages.
    """

    def __init__(self, layout: Scenario, collisions: str = "stop") -> None:
        columns = layout.commands[..., None]
        self.commands = [[np.array(each) for each in row] for row in columns]
        self._env = irsim.make(world_file(layout.discs, layout.poses, collisions), **_quiet())
        self._ids = list(range(len(layout.poses)))
        self._env.step([np.zeros((2, 1)) for _ in self._ids], self._ids)  # its first scans

    def step(self, commands: Any) -> None:
        """Commands all robots, steps, and reads all scans."""
        self._env.step(commands, self._ids)
        for robot in self._env.robot_list:
            robot.get_lidar_scan()["ranges"]

    def scans(self) -> Any:
        """The ranges of all lidars [m]."""
        return [robot.get_lidar_scan()["ranges"] for robot in self._env.robot_list]


class Batch:
    """Robots, each alone in a copy of the room: irsim-x's `make(batch_size=...)`.

    Its obstacles are not read from the file; they are the same for all robots. The batch only
    reports collisions, and robots drive on.

    Args:
        layout: the scenario.
    """

    def __init__(self, layout: Scenario) -> None:
        # Forward velocity, velocity to the left (none), yaw rate.
        speeds, yaw_rates = np.moveaxis(layout.commands, -1, 0)
        columns = (speeds, np.zeros_like(speeds), yaw_rates)
        self.commands = np.stack(columns, axis=-1).astype(np.float32)
        world = world_file(layout.discs, layout.poses[:1], "stop")
        self._env = irsim.make(world, batch_size=len(layout.poses))
        # Its lidar knows the walls only if another obstacle is added after them.
        self._env.batch_cpp.add_linestring_obstacle(_corners())
        for x, y in layout.discs.tolist():
            circle = {"type": "circle", "x": x, "y": y, "radius": scenario.DISC_RADIUS}
            self._env.add_obstacle(circle)
        self._env.set_poses(layout.poses.astype(np.float32))

    def step(self, commands: Any) -> None:
        """Commands, steps and scans."""
        self._env.step(commands)
        self._env.get_lidar_scan()

    def scans(self) -> Any:
        """The ranges of all lidars [m]."""
        return self._env.get_lidar_scan()


def world_file(discs: Any, poses: Any, collisions: str) -> str:
    """Writes a world with discs, and robots at these poses; returns the path of its file."""
    circle = {"name": "circle", "radius": scenario.DISC_RADIUS}
    obstacles: Any = [{"shape": circle, "state": [x, y, 0.0]} for x, y in discs.tolist()]
    walls = {"name": "linestring", "vertices": _corners()}
    obstacles.append({"shape": walls, "state": [0.0, 0.0, 0.0]})
    lidar = {
        "name": "lidar2d",
        "range_max": scenario.RANGE,
        "number": scenario.BEAMS,
        "angle_range": 2 * math.pi - 1e-6,  # irsim-x makes 0 of a whole turn
    }
    robots = [
        {
            "kinematics": {"name": "diff"},
            "shape": {"name": "circle", "radius": scenario.ROBOT_RADIUS},
            "state": pose,
            "vel_min": [-scenario.SPEED, -scenario.YAW_RATE],
            "vel_max": [scenario.SPEED, scenario.YAW_RATE],
            "sensors": [lidar],
        }
        for pose in poses.tolist()
    ]
    robot = robots if len(robots) > 1 else robots[0]
    world = {
        "width": scenario.ROOM,
        "height": scenario.ROOM,
        "step_time": scenario.STEP,
        "collision_mode": collisions,
    }
    with tempfile.NamedTemporaryFile("w", suffix=".yaml", delete=False) as file:
        yaml.safe_dump({"world": world, "robot": robot, "obstacle": obstacles}, file)
    return file.name


def _quiet() -> Dict[str, Any]:
    """Arguments of ir-sim, without a figure and a window; a name depends on the version."""
    known = inspect.signature(irsim.env.env_base.EnvBase.__init__).parameters
    quiet = "headless" if "headless" in known else "disable_all_plot"
    return {"display": False, "log_level": "ERROR", quiet: True}


def _corners() -> Any:
    side = scenario.ROOM
    return [[0.0, 0.0], [side, 0.0], [side, side], [0.0, side], [0.0, 0.0]]
