"""The room in Flatland: robots in one `Simulation`, or a `SimulationBatch`."""

import math
from typing import Any, Dict, List

import numpy as np

import scenario
from flatland2d import Float32Array, Simulation, SimulationBatch
from scenario import Scenario


class Room:
    """Robots in one world, which see and hit each other.

    Args:
        layout: the scenario.
        substeps: physics steps in a step.
    """

    def __init__(self, layout: Scenario, substeps: int = 1) -> None:
        self.commands = layout.commands.tolist()
        self._substeps = substeps
        world = world_of(layout.discs, layout.poses)
        self._simulation = Simulation(world, step_size=scenario.STEP / substeps)
        models = self._simulation.models
        robots = [models[f"robot_{number}"] for number in range(len(layout.poses))]
        self._drives = [robot.drives["drive"] for robot in robots]
        self._lasers = [robot.sensors["laser"] for robot in robots]

    def step(self, commands: List[List[float]]) -> None:
        """Commands all robots, steps, and reads all scans."""
        for drive, (speed, yaw_rate) in zip(self._drives, commands):
            drive.command(speed, yaw_rate)
        self._simulation.step(self._substeps)
        for laser in self._lasers:
            laser.read()

    def scans(self) -> Float32Array:
        """The ranges of all lidars [m]; no return reads as the maximum range."""
        return np.minimum([laser.read() for laser in self._lasers], scenario.RANGE)


class Batch:
    """Robots in worlds of their own.

    Args:
        layout: the scenario.
        substeps: physics steps in a step.
    """

    def __init__(self, layout: Scenario, substeps: int = 1) -> None:
        self.commands = layout.commands.astype(np.float32)
        self._substeps = substeps
        world, count = world_of(layout.discs, layout.poses[:1]), len(layout.poses)
        self._batch = SimulationBatch(world, count, step_size=scenario.STEP / substeps)
        self._observation = self._batch.reset(poses=layout.poses)

    def step(self, commands: Float32Array) -> None:
        """Commands, steps and scans; the scans are in the observation."""
        self._batch.step(commands, self._substeps, out=self._observation)

    def scans(self) -> Float32Array:
        """The ranges of all lidars [m]; no return reads as the maximum range."""
        return np.minimum(self._observation.ranges, scenario.RANGE)


def world_of(discs: "np.ndarray[Any, Any]", poses: "np.ndarray[Any, Any]") -> Dict[str, Any]:
    """The content of a world file with discs, and robots at these poses."""
    side = scenario.ROOM
    walls = {"polygons": [[[0.0, 0.0], [side, 0.0], [side, side], [0.0, side]]]}
    models: List[Dict[str, Any]] = []
    for number, (x, y) in enumerate(discs.tolist()):
        disc = {"bodies": [_body("static", scenario.DISC_RADIUS)]}
        models.append({"name": f"disc_{number}", "pose": [x, y, 0.0], "model": disc})
    for number, pose in enumerate(poses.tolist()):
        name = f"robot_{number}"
        models.append({"name": name, "namespace": name, "pose": pose, "model": _robot()})
    return {"properties": {}, "layers": [{"name": "room", "map": walls}], "models": models}


def _body(kind: str, radius: float) -> Dict[str, Any]:
    footprint = {"type": "circle", "radius": radius, "density": 1.0, "layers": ["room"]}
    return {"name": "base", "type": kind, "footprints": [footprint]}


def _robot() -> Dict[str, Any]:
    angle = {"min": scenario.FIRST_BEAM, "max": math.pi, "increment": scenario.INCREMENT}
    drive = {"type": "DiffDrive", "name": "drive", "body": "base", "odom_frame_id": "~odom"}
    laser = {
        "type": "Laser",
        "name": "laser",
        "body": "base",
        "range": scenario.RANGE,
        "angle": angle,
        "layers": ["room"],
    }
    return {"bodies": [_body("dynamic", scenario.ROBOT_RADIUS)], "plugins": [drive, laser]}
