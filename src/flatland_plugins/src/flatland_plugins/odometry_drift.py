"""Drift: errors of odometry that accumulate, as those of slipping wheels do."""

import math
from dataclasses import dataclass
from typing import Any, Dict, Optional, Tuple

import numpy as np

from flatland_server import Pose

Vector3 = Tuple[float, ...]


@dataclass(frozen=True)
class DriftVariances:
    """Growth rates of the variances of the estimated pose.

    The first four are alpha 1 to 4 of the velocity motion model (Thrun, Burgard and Fox,
    "Probabilistic Robotics", 5.3). There, an error is drawn for each interval of time, and its
    variance grows with the square of the velocity, so that the total depends on the length of the
    intervals. Here variances are proportional to the distance driven and the angle turned, so that
    they add up along a path, however it is divided. The model's final rotation (alpha 5 and 6)
    would only add to alpha 3 and 4.
    """

    translation_per_metre: float = 0.0
    """Along the direction of travel [m^2/m]."""
    translation_per_radian: float = 0.0
    """Along the body's x axis [m^2/rad]."""
    rotation_per_metre: float = 0.0
    """[rad^2/m]"""
    rotation_per_radian: float = 0.0
    """[rad^2/rad]"""
    per_second: Vector3 = (0.0, 0.0, 0.0)
    """Of x, y and yaw in the body's frame, also at rest [m^2/s, m^2/s, rad^2/s]."""

    def __bool__(self) -> bool:
        return self != DriftVariances()


class OdometryDrift:
    """The pose that a robot estimates by adding up motions that it measures with errors.

    Errors are in the body's frame, so that an error of the heading bends the path that follows.
    Their variances add up along the path and over time, however often `advance` is called, as long
    as the robot neither reverses nor turns by more than half a revolution between two calls.

    If the model is moved by `move_model`, the estimate moves with it: that jump has no error.

    Attributes:
        pose: the estimate.

    Args:
        variances: growth rates of the error.
        seed: of the noise.
    """

    def __init__(self, variances: DriftVariances, seed: int) -> None:
        self.pose = Pose()
        self._variances = variances
        self._drifts_at_rest = any(variances.per_second)
        self._deviations_at_rest = np.sqrt(variances.per_second)
        self._rng = np.random.default_rng(seed)
        self._last: Optional[Tuple[int, Pose]] = None

    def advance(self, nanoseconds: int, truth: Pose, *, has_jumped: bool = False) -> None:
        """Updates `pose` for a later time.

        The first call sets it to `truth`. Equal times and motions give equal poses.

        Args:
            nanoseconds: the time [ns].
            truth: the robot's pose at that time.
            has_jumped: whether the model was moved, rather than driven, since the last call.
        """
        if self._last is None:
            self.pose = truth
        else:
            then, before = self._last
            if truth != before or self._drifts_at_rest:
                motion = before.inverse().compose(truth).wrapped()
                driven = Pose() if has_jumped else motion
                error = self._error(driven, (nanoseconds - then) * 1e-9)
                # Half of it before the motion and half after: to second order, this is noise that
                # is spread over the motion, and bends the path as many small steps would.
                half = Pose(*(0.5 * each for each in error))
                self.pose = self.pose.compose(half).compose(motion).compose(half).wrapped()
        self._last = (nanoseconds, truth)

    def preview(self, nanoseconds: int, truth: Pose, *, has_jumped: bool = False) -> Pose:
        """The `pose` after `advance` with the same arguments; changes nothing."""
        before = self.get_state()
        self.advance(nanoseconds, truth, has_jumped=has_jumped)
        after = self.pose
        self.set_state(before)
        return after

    def get_state(self) -> Dict[str, Any]:
        """The estimate and the state of the generator, for a saved state."""
        rng = self._rng.bit_generator.state
        return {"pose": self.pose, "last": self._last, "rng": rng}

    def set_state(self, state: Dict[str, Any]) -> None:
        self.pose = Pose(*state["pose"])
        self._rng.bit_generator.state = state["rng"]
        self._last = None
        if state["last"] is not None:
            nanoseconds, truth = state["last"]
            self._last = (nanoseconds, Pose(*truth))

    def _error(self, motion: Pose, seconds: float) -> Pose:
        """An error [m, m, rad] of a motion, in the body's frame."""
        ahead = left = yaw = 0.0
        if motion != Pose():
            variances, normal = self._variances, self._rng.standard_normal(3).tolist()
            x, y = arc(motion)
            metres, radians = math.hypot(x, y), abs(motion.yaw)
            slip = 0.0  # per metre driven
            if metres > 0.0:
                slip = normal[0] * math.sqrt(variances.translation_per_metre / metres)
            ahead = slip * x + normal[1] * math.sqrt(variances.translation_per_radian * radians)
            left = slip * y
            yaw = normal[2] * math.sqrt(
                variances.rotation_per_metre * metres + variances.rotation_per_radian * radians
            )
        if self._drifts_at_rest:
            deviations = self._deviations_at_rest * math.sqrt(seconds)
            more = (self._rng.standard_normal(3) * deviations).tolist()
            ahead, left, yaw = ahead + more[0], left + more[1], yaw + more[2]
        return Pose(ahead, left, yaw)


def arc(motion: Pose) -> Tuple[float, float]:
    """The distances [m] driven along a body's x and y axes, if its motion is an arc.

    On an arc, the body's velocity in its own frame is constant; this is that velocity times the
    time. (The logarithm of a planar motion; Lynch and Park, "Modern Robotics", 3.3.3.)

    Args:
        motion: the end in the frame of the start, turned by less than half a revolution.
    """
    half = motion.yaw / 2
    cotangent = half / math.tan(half) if abs(half) > 1e-6 else 1.0
    return (
        cotangent * motion.x + half * motion.y,
        cotangent * motion.y - half * motion.x,
    )
