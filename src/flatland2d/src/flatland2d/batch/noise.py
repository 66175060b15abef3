"""The noise of the lidars of a batch."""

from typing import Dict, List, Mapping, Optional, Sequence, Set

import numpy as np

from flatland2d.robot import Robot
from flatland_server import _core
from flatland_server.arrays import BoolArray, Float32Array, FloatArray, IntArray
from flatland_server.plugins import AddNoise, plugin_rng


class BatchNoises:
    """The noise of the lidars of m robots in each environment.

    Args:
        robots: their models and lidars.
        count: number of environments, n.
        settings: see `BatchNoise`, by the robots' indices.
    """

    def __init__(
        self, robots: Sequence[Robot], count: int, settings: Mapping[int, FloatArray]
    ) -> None:
        self._noises = [
            BatchNoise(robot, count, settings.get(index)) for index, robot in enumerate(robots)
        ]
        self._is_noisy = any(self._noises)

    def __bool__(self) -> bool:
        """True if a lidar has noise."""
        return self._is_noisy

    def restart(self, environments: Sequence[int]) -> None:
        """As `BatchNoise.restart`, for all robots."""
        for noise in self._noises:
            noise.restart(environments)

    def add(
        self,
        ranges: Float32Array,
        seeds: IntArray,
        nanoseconds: IntArray,
        driven: Optional[BoolArray],
    ) -> None:
        """Adds the noise at times [ns] to the ranges of the robots in the mask.

        Args:
            ranges: (n, beams), or (n, m, beams).
            seeds: of the environments, (n,).
            nanoseconds: the time of each, (n,).
            driven: which robots, (n * m,); None: all.
        """
        count = len(seeds)
        rows = ranges.reshape(count, len(self._noises), -1)
        for index, noise in enumerate(self._noises):
            if noise:
                own = np.ascontiguousarray(rows[:, index])
                mask = None if driven is None else driven.reshape(count, -1)[:, index].copy()
                noise.add(own, seeds, nanoseconds, mask)
                rows[:, index] = own


class BatchNoise:
    """Adds the noise of the lidar in a `Simulation` with the environment's seed.

    Args:
        robot: the robot with the lidar.
        count: number of environments, n.
        settings: see `RangeNoise.settings`, where they differ between environments: (n, 3).
    """

    def __init__(self, robot: Robot, count: int, settings: Optional[FloatArray] = None) -> None:
        self._settings = settings
        self._robot = robot
        self._make_noise = robot.core_lidar.make_noise
        self._noises: List[Optional[AddNoise]] = [None] * count
        self._keys = np.zeros(count, np.uint64)
        self._new: Set[int] = set(range(count))

    def __bool__(self) -> bool:
        """True if the lidar has noise."""
        return self._make_noise is not None

    def restart(self, environments: Sequence[int]) -> None:
        """Makes new noise for environments with changed seeds, at the next `add`."""
        self._new.update(environments)

    def add(
        self,
        ranges: Float32Array,
        seeds: IntArray,
        nanoseconds: IntArray,
        mask: Optional[BoolArray],
    ) -> None:
        """Adds the noise at times [ns] to ranges (n, beams); with a mask, only to its rows."""
        self._make(seeds)
        first = self._noises[0]
        if isinstance(first, _core.RangeNoise):  # then all are of this type
            first.add_to_rows(ranges, self._keys, nanoseconds, mask, self._settings)
            return
        for k in range(len(ranges)) if mask is None else np.flatnonzero(mask).tolist():
            noise = self._noises[k]
            assert noise is not None
            ranges[k] = noise(ranges[k], int(nanoseconds[k]))

    def _make(self, seeds: IntArray) -> None:
        """Makes the noise of environments with new seeds."""
        assert self._make_noise is not None
        made: Dict[int, _core.RangeNoise] = {}  # by seeds: it keeps nothing from call to call
        for k in self._new:
            seed = int(seeds[k])
            if seed not in made:
                rng = plugin_rng(seed, self._robot.model.name, self._robot.lidar.name)
                noise = self._noises[k] = self._make_noise(rng)
                if not isinstance(noise, _core.RangeNoise):
                    continue
                made[seed] = noise
            self._noises[k] = made[seed]
            self._keys[k] = made[seed].key
        self._new.clear()
