"""Drift: errors of wheels' measured motion, which accumulate in odometry's pose."""

from dataclasses import dataclass
from typing import Tuple

from flatland_server import Drift, ModelBody

Vector3 = Tuple[float, ...]


@dataclass(frozen=True)
class DriftVariances:
    """Growth rates of the variances of the estimated pose, and biases of the wheels.

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
    biases: Vector3 = (0.0, 0.0, 0.0)
    """Standard deviations of the errors that stay the same in a run: of the wheels' radius and of
    the track width, relative, and of the curvature of a straight path [rad/m]."""

    def __bool__(self) -> bool:
        return self != DriftVariances()

    def add_to(self, body: ModelBody, key: int, period: float = 0.0) -> Drift:
        """Adds a drift of these variances to a body, in the core; see `Body.add_drift`.

        Args:
            body: body with the origin that is tracked.
            key: key of the random numbers: equal keys give equal errors.
            period: between two updates [s]; 0 if every step is one.
        """
        return body.physics_body.add_drift(
            key,
            (self.translation_per_metre, self.translation_per_radian),
            (self.rotation_per_metre, self.rotation_per_radian),
            self.per_second,
            self.biases,
            period,
        )
