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

COLLISIONS = {"": "stop", "contact": "contact"}
"""`collision_mode` of the world, by the variant. "stop" is the default of both packages."""


class Room:
    """Robots in one world.

    Args:
        robots: number of robots.
        seed: seed of the robots' places and commands; see `Scenario`.
        collisions: the world's `collision_mode`.
    """

    def __init__(self, robots: int, seed: int, collisions: str) -> None:
        self.robots = robots
        self._scenario = Scenario(robots, seed)
        self._step = 0
        self._env = irsim.make(world_file(self._scenario, collisions), **_quiet())
        self._ids = list(range(robots))
        columns = self._scenario.commands[..., None]
        self._commands = [[np.array(each) for each in row] for row in columns]
        self._env.step([np.zeros((2, 1))] * robots, self._ids)  # its first scans

    def run(self, steps: int) -> None:
        """Commands all robots, steps, and reads all scans."""
        for _ in range(steps):
            self._env.step(self._commands[self._scenario.command(self._step)], self._ids)
            for robot in self._env.robot_list:
                robot.get_lidar_scan()["ranges"]
            self._step += 1

    def scans(self) -> Any:
        """The ranges of all lidars [m]."""
        return np.array([robot.get_lidar_scan()["ranges"] for robot in self._env.robot_list])

    def close(self) -> None:
        """Ends the environment."""
        self._env.end(ending_time=0.0)


class Batch:
    """Robots, each alone in a copy of the room: irsim-x's `make(batch_size=...)`.

    Its obstacles are not read from the file; they are the same for all robots.

    Args:
        robots: number of robots.
        seed: seed of the robots' places and commands; see `Scenario`.
        collisions: ignored: the batch only reports collisions, and robots drive on.
    """

    def __init__(self, robots: int, seed: int, collisions: str) -> None:
        self.robots = robots
        self._scenario = Scenario(robots, seed, rooms=robots)
        self._step = 0
        self._env = irsim.make(world_file(Scenario(1, seed), collisions), batch_size=robots)
        # Its lidar knows the walls only if another obstacle is added after them.
        self._env.batch_cpp.add_linestring_obstacle(_corners())
        for x, y in self._scenario.discs.tolist():
            circle = {"type": "circle", "x": x, "y": y, "radius": scenario.DISC_RADIUS}
            self._env.add_obstacle(circle)
        self._env.set_poses(self._scenario.poses.astype(np.float32))
        # Forward velocity, velocity to the left (none), yaw rate.
        zeros = np.zeros_like(self._scenario.commands[..., 0])
        columns = (self._scenario.commands[..., 0], zeros, self._scenario.commands[..., 1])
        self._commands = np.stack(columns, axis=-1).astype(np.float32)

    def run(self, steps: int) -> None:
        """Commands, steps and scans."""
        for _ in range(steps):
            self._env.step(self._commands[self._scenario.command(self._step)])
            self._env.get_lidar_scan()
            self._step += 1

    def scans(self) -> Any:
        """The ranges of all lidars [m]."""
        return self._env.get_lidar_scan()

    def close(self) -> None:
        """Ends the batch."""
        self._env.close()


def open_room(kind: str, variant: str, robots: int, seed: int) -> Any:
    """A `Room` or a `Batch`, by the kind."""
    return (Batch if kind == "batch" else Room)(robots, seed, COLLISIONS[variant])


def world_file(layout: Scenario, collisions: str) -> str:
    """Writes the world; returns the path of its file."""
    x, y = layout.discs.T
    obstacles: Any = [
        {
            "shape": {"name": "circle", "radius": scenario.DISC_RADIUS},
            "state": [float(a), float(b), 0.0],
        }
        for a, b in zip(x, y)
    ]
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
        for pose in layout.poses.tolist()
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
