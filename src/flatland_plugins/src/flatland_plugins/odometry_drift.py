"""Drift: errors of odometry that accumulate, as those of slipping wheels do."""

import math
from typing import Optional, Sequence, Tuple

import numpy as np

from flatland_server import Pose


class OdometryDrift:
    """The pose that a robot estimates from velocities with white noise.

    The noise is in the body's frame, so that an error of the heading bends the path that follows.
    Over T seconds the integrated noise has the variances q T, however often `advance` is called; on
    a robot at rest that is the error of the estimate. (Thrun, Burgard and Fox, "Probabilistic
    Robotics", 5.4, compose relative motions in the same way, with noise per distance instead of
    time.)

    If the model is moved, the estimate moves with it, as without drift: the jump is a relative
    motion like any other.

    Attributes:
        pose: the estimate.

    Args:
        variances: q, of x, y and yaw per second [m^2/s, m^2/s, rad^2/s].
        seed: of the noise.
    """

    def __init__(self, variances: Sequence[float], seed: int) -> None:
        self.pose = Pose()
        self._deviation = np.sqrt(variances)
        self._rng = np.random.default_rng(seed)
        self._last: Optional[Tuple[int, Pose]] = None

    def advance(self, nanoseconds: int, truth: Pose) -> None:
        """Updates `pose` for a later time [ns], at which the robot is at `truth`.

        The first call sets it to `truth`. Equal times and motions give equal poses.
        """
        if self._last is None:
            self.pose = truth
        else:
            then, before = self._last
            root = math.sqrt((nanoseconds - then) * 1e-9)
            error = self._rng.standard_normal(3) * self._deviation * root
            # Half of it before the motion and half after: to second order, this is noise that is
            # spread over the interval, and bends the path as many small steps would.
            half = Pose(*(0.5 * error).tolist())
            motion = before.inverse().compose(truth)
            self.pose = self.pose.compose(half).compose(motion).compose(half).wrapped()
        self._last = (nanoseconds, truth)
