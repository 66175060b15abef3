"""Motions of bodies by a plugin in the environments of a batch: `BatchMotion`."""

from abc import ABC, abstractmethod
from typing import Optional, Sequence

import numpy as np

from flatland_server import _core
from flatland_server.arrays import FloatArray, IntArray, Segments


class BatchMotion(ABC):
    """Bodies that a plugin moves in n environments: it sets their velocities at its updates.

    It computes, bit for bit, the velocities that the plugin's `before_physics_step` sets, for many
    environments in one call. That hook should call it for one. See `Plugin.make_batch_motion`.

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
            environment: its index.
            rng: the random numbers of the plugin there (`Plugin.rng`).
            walls: of each layer of its world (`World.layers`), where a plugin adds some by chance;
                None: they are those of the plugin's world.
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
            environments: indices of those k that are updated, in increasing order.
            poses: of `bodies` there, (k, m, 3): x, y [m] and yaw in [-pi, pi] [rad].
            velocities: of their origins, in the world's frame [m/s, m/s, rad/s], (k, m, 3).
            step_size: of the simulation [s].

        Returns:
            Those of the origins of `moved`, in the world's frame, (k, bodies, 3).
        """
