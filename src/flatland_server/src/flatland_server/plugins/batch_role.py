"""A plugin's declaration for batches of environments: `BatchRole` and its parts."""

from abc import ABC, abstractmethod
from typing import Any, Callable, NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np

from flatland_server import _core
from flatland_server.arrays import Float32Array, FloatArray, IntArray, Segments

AddNoise = Callable[[Float32Array, int], Float32Array]
"""Returns ranges [m] with noise at a simulated time [ns], as `RangeNoise` does."""


class CoreDrive(NamedTuple):
    """A drive that the core moves at every step, and that obeys `ModelPlugin.command`."""

    drive: Union[_core.Drive, _core.Tricycle, _core.Ackermann]
    columns: Tuple[int, ...]
    """The index of the drive's number that each value of a command sets: among vx, vy and omega of
    a `Drive`, or the speed and the steering angle of a `Tricycle` or an `Ackermann`. The others
    are 0."""
    limits: Tuple[float, ...]
    """The greatest magnitude of each value; 0 is no limit."""
    is_random: bool = False
    """True if its actuators have noise, with the first number of the plugin's `rng` as the key.
    Each environment of a batch gets the key of its own seed."""


class CoreLidar(NamedTuple):
    """A lidar of the core; `ModelPlugin.read` returns its ranges, perhaps with noise."""

    lidar: _core.Lidar
    range: float
    """The largest distance that is measured [m]."""
    make_noise: Optional[Callable[[np.random.Generator], AddNoise]]
    """Makes the noise of a plugin from its random numbers (`Plugin.rng`); None: no noise."""


class BatchMotion(ABC):
    """Bodies that a plugin moves in n environments: it sets their velocities at its updates.

    It computes, bit for bit, the velocities that the plugin's `before_physics_step` sets, for many
    environments in one call. That hook should call it for one.

    Args:
        rate: of the updates [Hz], due as with an `UpdateTimer`; infinity is each step.

    Attributes:
        bodies: the m bodies with poses and velocities passed to `update`; set by the derived class.
        moved: the bodies that it moves; likewise.
    """

    bodies: Sequence[_core.Body]
    moved: Sequence[_core.Body]

    def __init__(self, rate: float) -> None:
        self.rate = rate

    @abstractmethod
    def begin(
        self,
        environment: int,
        rng: np.random.Generator,
        walls: Optional[Sequence[Segments]],
    ) -> None:
        """Called when an environment is reset.

        Args:
            environment: index of the environment, from 0.
            rng: the random numbers of the plugin there (`Plugin.rng`).
            walls: of each layer of its world (`World.layers`), if plugins add some at random; None:
                the walls are those of the plugin's world.
        """

    @abstractmethod
    def update(
        self,
        environments: IntArray,
        poses: FloatArray,
        velocities: FloatArray,
        step_size: float,
    ) -> FloatArray:
        """The velocities of the bodies that it moves until its next update.

        Args:
            environments: indices of the k environments to update, in increasing order.
            poses: of `bodies` there, (k, m, 3): x, y [m] and yaw in [-pi, pi] [rad].
            velocities: of their origins, in the world's frame [m/s, m/s, rad/s], (k, m, 3).
            step_size: of the simulation [s].

        Returns:
            Velocities of the origins of `moved`, in the world's frame, (k, bodies, 3).
        """

    def get_state(self, environment: int) -> Any:
        """All that `update` depends on and that changes, but for the random numbers.

        Override it for states of batches and branches of a simulation. The plugin's own
        `get_state` has to give the same.

        Args:
            environment: index of the environment, from 0.
        """
        raise NotImplementedError(f"{type(self).__name__} has no get_state")

    def set_state(self, environment: int, state: Any) -> None:
        """Restores an environment, which was begun before.

        Args:
            environment: index of the environment, from 0.
            state: result of `get_state`, of this role or of the plugin.
        """
        raise NotImplementedError(f"{type(self).__name__} has no set_state")


class BatchRole(NamedTuple):
    """A plugin's part in the environments of a `SimulationBatch`, which calls none of its hooks.

    Without arguments: the plugin is left out, since it changes nothing in the world by itself. Its
    hooks only observe; it may obey messages.
    """

    drive: Optional[CoreDrive] = None
    """The drive that its `command` controls; the batch commands it directly."""
    lidar: Optional[CoreLidar] = None
    """The lidar that its `read` reads."""
    crowd: Optional[_core.Crowd] = None
    """The crowd of the core that it has added with a number from its `rng` as the key. Each
    environment gets the key of its own seed."""
    before_scatter: Optional[bytes] = None
    """`World.save_state` before `Crowd.scatter`, if people draw their places by that key. Each
    environment then draws its own."""
    make_motion: Optional[Callable[[int], BatchMotion]] = None
    """Makes the motion of the bodies that the plugin moves at its updates, for a number of
    environments. Called when all models and plugins of the world have been made."""
    varies_by_seed: bool = False
    """True if `on_initialize` changes the world at random, as by adding walls: each environment
    then has its own world, loaded with its seed."""
