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
        layout: the scenario.
    """

    def __init__(self, layout: Scenario) -> None:
        robots = len(layout.poses)
        self.commands = layout.commands.astype(np.float32)
        limits = {
            "vmin": -scenario.SPEED,
            "vmax": scenario.SPEED,
            "wmin": -scenario.YAW_RATE,
            "wmax": scenario.YAW_RATE,
        }
        self._simulators = jalansim.make("diff_drive", robots, limits, radius=scenario.ROBOT_RADIUS)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "map.pgm"
            squares = scenario.squares(layout.discs, _SQUARE)
            size = f"P5 {squares.shape[1]} {squares.shape[0]} 255\n".encode()
            path.write_bytes(size + np.where(squares[::-1], 0, 255).astype(np.uint8).tobytes())
            self._map = jalansim.Map.load_image(str(path), _SQUARE, -_SQUARE, -_SQUARE, 0.0)
        self._map.update_dist(scenario.RANGE)
        self._simulators.set_map(self._map)
        self._simulators.reset()
        self._simulators.set_state(layout.poses.astype(np.float32))
        self._ranges = np.zeros((robots, scenario.BEAMS), np.float32)

    def step(self, commands: Any) -> None:
        """Commands, steps and scans."""
        self._simulators.step(commands, scenario.STEP)
        self.scans()

    def scans(self) -> Any:
        """The ranges of all lidars [m]."""
        self._simulators.get_range(self._ranges, scenario.BEAMS, 2.0 * math.pi, scenario.RANGE)
        return self._ranges


Room = Batch  # of one robot
