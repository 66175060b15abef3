"""The keys of a drive that concern its odometry."""

from dataclasses import dataclass
from typing import Tuple

from flatland_server import Drift, ModelBody, YamlReader

Vector3 = Tuple[float, ...]

_NO_NOISE = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class DriftVariances:
    """Drift: growth rates of the variances of the estimated pose, and biases of the wheels.

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


@dataclass(frozen=True)
class OdometryConfig:
    """The keys of a drive that concern odometry, except its frames.

    Noises are variances of x, y and yaw, or of their velocities; each message gets new noise. Drift
    is in the core: the measured velocity has its errors, and the pose accumulates them.
    """

    odom_pub: str
    ground_truth_pub: str
    twist_pub: str
    enable_odom_pub: bool
    enable_twist_pub: bool
    enable_odom_tf_pub: bool
    twist_in_local_frame: bool
    pose_noise: Vector3
    twist_noise: Vector3
    drift: DriftVariances
    pose_covariance: Vector3
    twist_covariance: Vector3

    @classmethod
    def read(
        cls,
        config: YamlReader,
        enable_twist_pub: bool = True,
        enable_odom_tf_pub: bool = True,
        odom_pub: str = "odometry/filtered",
    ) -> "OdometryConfig":
        """Reads the keys, as documented, from a drive's configuration.

        Args:
            config: the drive's entry in the model file.
            enable_twist_pub: default of the key `enable_twist_pub`.
            enable_odom_tf_pub: default of the key `enable_odom_tf_pub`.
            odom_pub: default of the key `odom_pub`.
        """
        pose_noise = config.get_floats("odom_pose_noise", 3, _NO_NOISE, minimum=0.0)
        twist_noise = config.get_floats("odom_twist_noise", 3, _NO_NOISE, minimum=0.0)
        return cls(
            odom_pub=config.get_topic("odom_pub", odom_pub),
            ground_truth_pub=config.get_topic("ground_truth_pub", "odometry/ground_truth"),
            twist_pub=config.get_topic("twist_pub", "twist"),
            enable_odom_pub=config.get_bool("enable_odom_pub", True),
            enable_twist_pub=config.get_bool("enable_twist_pub", enable_twist_pub),
            enable_odom_tf_pub=config.get_bool("enable_odom_tf_pub", enable_odom_tf_pub),
            twist_in_local_frame=config.get_bool("twist_in_local_frame", True),
            pose_noise=pose_noise,
            twist_noise=twist_noise,
            drift=_read_drift(config),
            pose_covariance=config.get_floats(
                "odom_pose_covariance", 36, planar_covariance(pose_noise)
            ),
            twist_covariance=config.get_floats(
                "odom_twist_covariance", 36, planar_covariance(twist_noise)
            ),
        )


def _read_drift(config: YamlReader) -> DriftVariances:
    """The drift: a map, or a list of variances per second."""
    key = "odom_drift"
    if config.is_list(key):
        return DriftVariances(per_second=config.get_floats(key, 3, minimum=0.0))
    section = config.get_section(key)
    drift = DriftVariances(
        translation_per_metre=section.get_float("translation_per_metre", 0.0, minimum=0.0),
        translation_per_radian=section.get_float("translation_per_radian", 0.0, minimum=0.0),
        rotation_per_metre=section.get_float("rotation_per_metre", 0.0, minimum=0.0),
        rotation_per_radian=section.get_float("rotation_per_radian", 0.0, minimum=0.0),
        per_second=section.get_floats("per_second", 3, _NO_NOISE, minimum=0.0),
        biases=(
            section.get_float("wheel_radius_bias", 0.0, minimum=0.0),
            section.get_float("track_width_bias", 0.0, minimum=0.0),
            section.get_float("curvature_bias", 0.0, minimum=0.0),
        ),
    )
    section.finish()
    return drift


def planar_covariance(variances: Vector3) -> Vector3:
    """A 6x6 covariance, row by row, of the variances of x, y and yaw (REP 103's order of axes)."""
    covariance = [0.0] * 36
    covariance[0], covariance[7], covariance[35] = variances
    return tuple(covariance)
