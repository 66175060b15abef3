"""The parts of the core that a plugin's drive or lidar consists of, for batches of environments."""

from typing import Callable, NamedTuple, Optional, Tuple, Union

import numpy as np

from flatland_server import _core
from flatland_server.arrays import Float32Array

AddNoise = Callable[[Float32Array, int], Float32Array]
"""Ranges with noise, of ranges [m] without it and the simulated time [ns]: such as `RangeNoise`."""


class CoreDrive(NamedTuple):
    """A drive that the core moves at every step, and that obeys `ModelPlugin.command`."""

    drive: Union[_core.Drive, _core.Tricycle]
    columns: Tuple[int, ...]
    """Which of the drive's numbers each value of a command is: of vx, vy and omega of a `Drive`, or
    of the speed and the steering angle of a `Tricycle`. The others are 0."""
    limits: Tuple[float, ...]
    """The greatest magnitude of each value; 0 is no limit."""


class CoreLidar(NamedTuple):
    """A lidar of the core; `ModelPlugin.read` returns its ranges, perhaps with noise."""

    lidar: _core.Lidar
    range: float
    """The largest distance that is measured [m]."""
    make_noise: Optional[Callable[[np.random.Generator], AddNoise]]
    """Makes the noise of a plugin out of its random numbers (`Plugin.rng`); None: no noise."""
