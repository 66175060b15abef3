"""The keys of a drive that concern its odometry."""

from dataclasses import dataclass
from typing import Tuple

import numpy as np

from flatland_server import YamlReader

Vector3 = Tuple[float, ...]


@dataclass(frozen=True)
class OdometryConfig:
    """The keys of a drive that concern odometry.

    Noises are variances of x, y and yaw, or of their velocities, drawn anew for each message. Drift
    accumulates: variances per second [m^2/s, m^2/s, rad^2/s] in the body's frame; see
    `OdometryDrift`.
    """

    odom_frame_id: str
    ground_truth_frame_id: str
    odom_pub: str
    ground_truth_pub: str
    twist_pub: str
    enable_odom_pub: bool
    enable_twist_pub: bool
    enable_odom_tf_pub: bool
    twist_in_local_frame: bool
    pose_noise: Vector3
    twist_noise: Vector3
    drift: Vector3
    pose_covariance: Vector3
    twist_covariance: Vector3

    @classmethod
    def read(cls, config: YamlReader, enable_twist_pub: bool = True) -> "OdometryConfig":
        """Reads the keys, as documented, from a drive's configuration.

        Args:
            config: of the drive.
            enable_twist_pub: the default of that key.
        """
        pose_noise = config.get_floats("odom_pose_noise", 3, (0.0, 0.0, 0.0), minimum=0.0)
        twist_noise = config.get_floats("odom_twist_noise", 3, (0.0, 0.0, 0.0), minimum=0.0)
        return cls(
            odom_frame_id=config.get_frame("odom_frame_id", "odom"),
            ground_truth_frame_id=config.get_frame("ground_truth_frame_id", "map"),
            odom_pub=config.get_topic("odom_pub", "odometry/filtered"),
            ground_truth_pub=config.get_topic("ground_truth_pub", "odometry/ground_truth"),
            twist_pub=config.get_topic("twist_pub", "twist"),
            enable_odom_pub=config.get_bool("enable_odom_pub", True),
            enable_twist_pub=config.get_bool("enable_twist_pub", enable_twist_pub),
            enable_odom_tf_pub=config.get_bool("enable_odom_tf_pub", True),
            twist_in_local_frame=config.get_bool("twist_in_local_frame", True),
            pose_noise=pose_noise,
            twist_noise=twist_noise,
            drift=config.get_floats("odom_drift", 3, (0.0, 0.0, 0.0), minimum=0.0),
            pose_covariance=config.get_floats(
                "odom_pose_covariance", 36, planar_covariance(pose_noise)
            ),
            twist_covariance=config.get_floats(
                "odom_twist_covariance", 36, planar_covariance(twist_noise)
            ),
        )


def planar_covariance(variances: Vector3) -> Vector3:
    """A 6x6 covariance, row by row, of the variances of x, y and yaw (REP 103's order of axes)."""
    diagonal = (variances[0], variances[1], 0.0, 0.0, 0.0, variances[2])
    return tuple(np.diag(diagonal).ravel().tolist())
