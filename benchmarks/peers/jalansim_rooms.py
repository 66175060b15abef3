"""The room in JalanSim, which has batches of robots that are alone in a map of squares."""

import math
import os
import tempfile
from pathlib import Path
from typing import Any

os.environ["USE_CUDA"] = "0"

import jalansim
import numpy as np

import scenario
from scenario import Scenario

_SQUARE = 0.1
"""Side of a square of its map [m]."""


class Batch:
    """Robots, each alone in the room, which is the same for all.

    Args:
        robots: number of robots.
        seed: seed of the robots' places and commands; see `Scenario`.
    """

    def __init__(self, robots: int, seed: int) -> None:
        self.robots = robots
        self._scenario = Scenario(robots, seed, rooms=robots)
        self._step = 0
        limits = {
            "vmin": -scenario.SPEED,
            "vmax": scenario.SPEED,
            "wmin": -scenario.YAW_RATE,
            "wmax": scenario.YAW_RATE,
        }
        self._simulators = jalansim.make("diff_drive", robots, limits, radius=scenario.ROBOT_RADIUS)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "map.pgm"
            squares = scenario.squares(self._scenario.discs, _SQUARE)
            size = f"P5 {squares.shape[1]} {squares.shape[0]} 255\n".encode()
            path.write_bytes(size + np.where(squares[::-1], 0, 255).astype(np.uint8).tobytes())
            self._map = jalansim.Map.load_image(str(path), _SQUARE, -_SQUARE, -_SQUARE, 0.0)
        self._map.update_dist(scenario.RANGE)
        self._simulators.set_map(self._map)
        self._simulators.reset()
        self._simulators.set_state(self._scenario.poses.astype(np.float32))
        self._commands = self._scenario.commands.astype(np.float32)
        self._ranges = np.zeros((robots, scenario.BEAMS), np.float32)

    def run(self, steps: int) -> None:
        """Commands, steps and scans."""
        for _ in range(steps):
            self._simulators.step(self._commands[self._scenario.command(self._step)], scenario.STEP)
            self.scans()
            self._step += 1

    def scans(self) -> Any:
        """The ranges of all lidars [m]."""
        self._simulators.get_range(self._ranges, scenario.BEAMS, 2.0 * math.pi, scenario.RANGE)
        return self._ranges

    def close(self) -> None:
        """Does nothing."""


def open_room(kind: str, variant: str, robots: int, seed: int) -> Batch:
    """A `Batch`, also of one robot."""
    return Batch(robots, seed)
