"""Odometry: what a wheeled robot believes about its pose and velocity, and what is true."""

import math
from dataclasses import dataclass
from typing import List, Optional, Tuple

import numpy as np
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry

from flatland_plugins.messages import fill_twist, header
from flatland_plugins.odometry_drift import OdometryDrift
from flatland_plugins.odometry_writer import OdometryWriter, Twist
from flatland_plugins.timed_noise import TimedNoise
from flatland_server import Frames, ModelBody, ModelPlugin, Pose, Publisher, YamlReader, wrap_angle

Vector3 = Tuple[float, ...]


@dataclass(frozen=True)
class OdometryConfig:
    """The keys of a drive that concern odometry.

    Noises are variances, of x, y and yaw or of their velocities, and new at each message. The drift
    adds up: variances per second [m^2/s, m^2/s, rad^2/s] in the body's frame; see `OdometryDrift`.
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
            enable_twist_pub: whether the drive publishes its twist if the key is not given.
        """
        pose_noise = config.get_floats("odom_pose_noise", 3, (0.0, 0.0, 0.0), minimum=0.0)
        twist_noise = config.get_floats("odom_twist_noise", 3, (0.0, 0.0, 0.0), minimum=0.0)
        return cls(
            odom_frame_id=config.get_string("odom_frame_id", "odom"),
            ground_truth_frame_id=config.get_string("ground_truth_frame_id", "map"),
            odom_pub=config.get_string("odom_pub", "odometry/filtered"),
            ground_truth_pub=config.get_string("ground_truth_pub", "odometry/ground_truth"),
            twist_pub=config.get_string("twist_pub", "twist"),
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
    """A 6x6 covariance of x, y, z, roll, pitch, yaw, row by row, from those of x, y and yaw."""
    diagonal = (variances[0], variances[1], 0.0, 0.0, 0.0, variances[2])
    return tuple(np.diag(diagonal).ravel().tolist())


class OdometryPublisher:
    """Publishes a body's odometry with drift and noise, without, as a twist, and as a transform.

    The drift and the noise of the pose are in the odometry and the transform, the noise of the
    velocity is in the odometry and the twist. A model that is moved takes its odometry along.

    Args:
        plugin: the drive that it belongs to.
        body: whose odometry it is, about the body's origin.
        config: topics, frames, noise and drift.
    """

    def __init__(self, plugin: ModelPlugin, body: ModelBody, config: OdometryConfig) -> None:
        self._config = config
        self._body = body
        self._node = plugin.node
        self._noise = TimedNoise(plugin.rng)
        self._drift: Optional[OdometryDrift] = None
        if any(config.drift):
            self._drift = OdometryDrift(config.drift, int(plugin.rng.integers(2**63)))
        self._base_frame = plugin.name_space_tf(body.name)
        self._deviation = np.sqrt([*config.pose_noise, *config.twist_noise])
        self._is_noisy = bool(self._deviation.any())
        self._odom: Optional[Publisher] = None
        self._ground_truth: Optional[Publisher] = None
        self._twist: Optional[Publisher] = None
        if config.enable_odom_pub:
            self._odom = self._node.advertise(config.odom_pub, Odometry)
            self._ground_truth = self._node.advertise(config.ground_truth_pub, Odometry)
        if config.enable_twist_pub:
            self._twist = self._node.advertise(config.twist_pub, TwistStamped)
        self._odom_writer, self._ground_truth_writer = (
            OdometryWriter(
                frame_id, self._base_frame, config.pose_covariance, config.twist_covariance
            )
            for frame_id in (config.odom_frame_id, config.ground_truth_frame_id)
        )
        self._frame: Optional[Frames] = None
        if config.enable_odom_tf_pub:
            self._frame = self._node.open_frames((config.odom_frame_id, self._base_frame))

    def has_work(self) -> bool:
        """Whether `publish` does anything: somebody listens, or a drift gathers."""
        return self._drift is not None or self._has_subscribers()

    def publish(self, nanoseconds: int) -> None:
        """Publishes what is listened to, for the present pose and velocity.

        To be called whenever odometry is due, heard or not: drift gathers from call to call.
        """
        pose = self._body.pose
        if self._drift is not None:
            self._drift.advance(nanoseconds, pose)
            if not self._has_subscribers():
                return
        local: Twist = self._body.physics_body.local_velocity
        believed = pose if self._drift is None else self._drift.pose
        felt = local
        if self._is_noisy:
            noise = self._noise_at(nanoseconds)
            x, y, yaw = (value + error for value, error in zip(believed, noise))
            believed = Pose(x, y, wrap_angle(yaw))
            vx, vy, omega = (value + error for value, error in zip(local, noise[3:]))
            felt = (vx, vy, omega)

        if self._twist is not None and self._twist.has_subscribers:
            twist = TwistStamped(header=header(nanoseconds, self._base_frame))
            fill_twist(twist.twist, *felt)
            self._twist.publish(twist)
        if self._odom is not None and self._odom.has_subscribers:
            self._write(self._odom, self._odom_writer, nanoseconds, believed, felt)
        if self._ground_truth is not None and self._ground_truth.has_subscribers:
            self._write(self._ground_truth, self._ground_truth_writer, nanoseconds, pose, local)
        if self._frame is not None and self._node.transforms_have_subscribers:
            self._frame.send(nanoseconds, [believed])

    def _has_subscribers(self) -> bool:
        if self._frame is not None and self._node.transforms_have_subscribers:
            return True
        publishers = (self._twist, self._odom, self._ground_truth)
        return any(publisher is not None and publisher.has_subscribers for publisher in publishers)

    def _noise_at(self, nanoseconds: int) -> List[float]:
        """Of the pose and the velocity."""
        normal = self._noise.at(nanoseconds).standard_normal(6)
        noise: List[float] = (normal * self._deviation).tolist()
        return noise

    def _write(
        self,
        publisher: Publisher,
        writer: OdometryWriter,
        nanoseconds: int,
        pose: Pose,
        twist: Twist,
    ) -> None:
        if not self._config.twist_in_local_frame:
            vx, vy, omega = twist
            cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
            twist = (cos * vx - sin * vy, sin * vx + cos * vy, omega)
        publisher.write(writer, nanoseconds, pose, twist)
