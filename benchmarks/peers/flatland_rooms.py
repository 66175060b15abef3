"""The room in Flatland: robots in one `Simulation`, or a `SimulationBatch`."""

import math
import tempfile
from pathlib import Path
from typing import Any, Dict, List

import numpy as np

import scenario
from flatland2d import Float32Array, Simulation, SimulationBatch
from scenario import Scenario

SUBSTEPS = {"": 1, "20 x 5 ms": 20}
"""Physics steps in a step of the scenario, by the variant."""


class Room:
    """Robots in one world, which see and hit each other.

    Args:
        robots: number of robots.
        seed: seed of the robots' places and commands; see `Scenario`.
        substeps: physics steps in a step.
    """

    def __init__(self, robots: int, seed: int, substeps: int) -> None:
        self.robots = robots
        self._substeps = substeps
        self._scenario = Scenario(robots, seed)
        self._step = 0
        world = world_of(self._scenario)
        self._simulation = Simulation(world, step_size=scenario.STEP / substeps)
        models = [self._simulation.models[f"robot_{number}"] for number in range(robots)]
        self._drives = [model.drives["drive"] for model in models]
        self._lasers = [model.sensors["laser"] for model in models]
        self._commands = self._scenario.commands.tolist()

    def run(self, steps: int) -> None:
        """Commands all robots, steps, and reads all scans."""
        simulation, drives, lasers = self._simulation, self._drives, self._lasers
        for step in range(self._step, self._step + steps):
            commands = self._commands[self._scenario.command(step)]
            for drive, (speed, yaw_rate) in zip(drives, commands):
                drive.command(speed, yaw_rate)
            simulation.step(self._substeps)
            for laser in lasers:
                laser.read()
        self._step += steps

    def scans(self) -> Float32Array:
        """The ranges of all lidars [m]; no return reads as the maximum range."""
        return np.minimum([laser.read() for laser in self._lasers], scenario.RANGE)

    def close(self) -> None:
        """Ends the simulation."""
        self._simulation.close()


class Batch:
    """Robots in worlds of their own.

    Args:
        robots: number of robots.
        seed: seed of the robots' places and commands; see `Scenario`.
        substeps: physics steps in a step.
    """

    def __init__(self, robots: int, seed: int, substeps: int) -> None:
        self.robots = robots
        self._substeps = substeps
        self._scenario = Scenario(robots, seed, rooms=robots)
        self._step = 0
        step_size = scenario.STEP / substeps
        self._batch = SimulationBatch(world_of(Scenario(1, seed)), robots, step_size=step_size)
        self._observation = self._batch.reset(poses=self._scenario.poses)
        self._commands = self._scenario.commands.astype(np.float32)

    def run(self, steps: int) -> None:
        """Commands, steps and scans; the scans are in the observation."""
        for _ in range(steps):
            values = self._commands[self._scenario.command(self._step)]
            self._batch.step(values, self._substeps, out=self._observation)
            self._step += 1

    def scans(self) -> Float32Array:
        """The ranges of all lidars [m]; no return reads as the maximum range."""
        return np.minimum(self._observation.ranges, scenario.RANGE)

    def close(self) -> None:
        """Ends the batch."""
        self._batch.close()


def open_room(kind: str, variant: str, robots: int, seed: int) -> Any:
    """A `Room` or a `Batch`, by the kind."""
    return (Batch if kind == "batch" else Room)(robots, seed, SUBSTEPS[variant])


def world_of(layout: Scenario) -> Dict[str, Any]:
    """The world as the content of a world file. The file of its walls lies in a new folder."""
    folder = Path(tempfile.mkdtemp(prefix="flatland_peers_"))
    side = scenario.ROOM
    corners = [(0.0, 0.0), (side, 0.0), (side, side), (0.0, side)]
    lines = [f"{a} {b} {c} {d}\n" for (a, b), (c, d) in zip(corners, corners[1:] + corners[:1])]
    (folder / "walls.dat").write_text("".join(lines), encoding="utf-8")
    walls = "type: line_segments\ndata: walls.dat\nscale: 1\norigin: [0, 0, 0]\n"
    (folder / "walls.yaml").write_text(walls, encoding="utf-8")
    models: List[Dict[str, Any]] = []
    for number, (x, y) in enumerate(layout.discs.tolist()):
        disc = {"bodies": [_body("static", scenario.DISC_RADIUS)]}
        models.append({"name": f"disc_{number}", "pose": [x, y, 0.0], "model": disc})
    for number, pose in enumerate(layout.poses.tolist()):
        name = f"robot_{number}"
        models.append({"name": name, "namespace": name, "pose": pose, "model": _robot()})
    layers = [{"name": "room", "map": str(folder / "walls.yaml")}]
    return {"properties": {}, "layers": layers, "models": models}


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
