"""Drift: the errors of odometry that add up, as those of wheels that slip do."""

import math
from typing import Optional, Sequence, Tuple

import numpy as np

from flatland_server import Pose


class OdometryDrift:
    """Where a robot believes to be, whose measured velocities have white noise.

    Its own frame sees the noise, so that an error of the heading bends the path that follows. In T
    seconds the integrals of the noise gather the variances q T, however often `advance` is called;
    on a robot at rest that is its error. (Thrun, Burgard and Fox, "Probabilistic Robotics", 5.4,
    has the same composition of relative motions, with noise per distance instead of time.)

    A model that is moved takes its odometry along, as it does without drift: the jump is a relative
    motion like any other.

    Args:
        variances: q, those of the x, y and yaw gathered in a second [m^2/s, m^2/s, rad^2/s].
        seed: of the noise.
    """

    def __init__(self, variances: Sequence[float], seed: int) -> None:
        self.pose = Pose()
        self._deviation = np.sqrt(variances)
        self._rng = np.random.default_rng(seed)
        self._last: Optional[Tuple[int, Pose]] = None

    def advance(self, nanoseconds: int, truth: Pose) -> None:
        """Moves `pose` on to a later time [ns], at which the robot is at `truth`.

        The first call believes it. Equal times and motions give equal poses.
        """
        if self._last is None:
            self.pose = truth
        else:
            then, before = self._last
            root = math.sqrt((nanoseconds - then) * 1e-9)
            error = self._rng.standard_normal(3) * self._deviation * root
            # Half of it before the motion and half after: to second order, the noise is spread over
            # the time between, and the path bends as if there were many small steps.
            half = Pose(*(0.5 * error).tolist())
            motion = before.inverse().compose(truth)
            self.pose = self.pose.compose(half).compose(motion).compose(half).wrapped()
        self._last = (nanoseconds, truth)
