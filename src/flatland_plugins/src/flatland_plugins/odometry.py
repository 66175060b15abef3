"""Odometry: the estimated pose and the measured velocity of a wheeled robot, and the true ones."""

import math
from typing import NamedTuple, Optional

import numpy as np

from flatland_plugins.odometry_config import OdometryConfig
from flatland_plugins.odometry_writer import OdometryWriter, TwistWriter
from flatland_plugins.timed_noise import TimedNoise, draw_key
from flatland_server import (
    Frames,
    ModelBody,
    ModelPlugin,
    Pose,
    Publisher,
    Timekeeper,
    Velocity,
    YamlReader,
    wrap_angle,
)


class Odometry(NamedTuple):
    """Pose and velocity of a body."""

    pose: Pose
    """In the frame of odometry, or in the world."""
    velocity: Velocity
    """In the frame of the body."""


class OdometryPlugin(ModelPlugin):
    """Publishes a body's odometry with errors, the ground truth, its twist and its transform.

    Drift and the noise of the pose are in the odometry and the transform, the noise of the velocity
    is in the odometry and the twist. If a model is moved, its odometry moves with it.
    """

    quantities = ("ground_truth",)

    def read_frames(self, config: YamlReader) -> None:
        """Reads the frames of the estimated and of the true poses."""
        self._odom_frame = self.get_frame_id(config, "odom_frame_id", "odom")
        self._ground_truth_frame = self.get_frame_id(config, "ground_truth_frame_id", "map")

    def open_odometry(self, body: ModelBody, config: OdometryConfig) -> None:
        """Opens the topics, after `read_frames`.

        Args:
            body: its origin is tracked.
            config: topics, noise and drift.
        """
        self._odometry_config = config
        self._body = body
        self._noise = TimedNoise(self.rng)
        self._drift = config.drift.add_to(body, draw_key(self.rng)) if config.drift else None
        base_frame = self.name_space_tf(body.name)
        self._deviation = np.sqrt([*config.pose_noise, *config.twist_noise])
        self._is_noisy = bool(self._deviation.any())
        self._odom: Optional[Publisher] = None
        self._ground_truth: Optional[Publisher] = None
        self._twist: Optional[Publisher] = None
        if config.enable_odom_pub:
            self._odom = self.node.advertise(config.odom_pub, "nav_msgs/Odometry")
            self._ground_truth = self.node.advertise(config.ground_truth_pub, "nav_msgs/Odometry")
        if config.enable_twist_pub:
            self._twist = self.node.advertise(
                config.twist_pub, "geometry_msgs/TwistWithCovarianceStamped"
            )
        covariances = config.pose_covariance, config.twist_covariance
        self._odom_writer, self._ground_truth_writer = (
            OdometryWriter(frame, base_frame, *covariances)
            for frame in (self._odom_frame, self._ground_truth_frame)
        )
        self._twist_writer = TwistWriter(base_frame, config.twist_covariance)
        self._frame: Optional[Frames] = None
        if config.enable_odom_tf_pub:
            self._frame = self.node.open_frames((self._odom_frame, base_frame))
            if self._odom_frame != self._ground_truth_frame:  # all models share the world's frame
                self.node.claim_odometry_frame(self._odom_frame)

    def has_work(self) -> bool:
        """True if the odometry has a subscriber."""
        if self._frame is not None and self.node.transforms_have_subscribers:
            return True
        publishers = (self._twist, self._odom, self._ground_truth)
        return any(publisher is not None and publisher.has_subscribers for publisher in publishers)

    def before_physics_step(self, timekeeper: Timekeeper) -> None:
        """Publishes odometry on the topics that have subscribers."""
        now = timekeeper.nanoseconds
        estimate = self._publish(now)
        if self._frame is not None and self.node.transforms_have_subscribers:
            self._frame.send(now, [estimate.pose])

    def publish_now(self, timekeeper: Timekeeper) -> None:
        """Publishes the present pose and velocity."""
        self._publish(timekeeper.nanoseconds)

    def read(self, timekeeper: Timekeeper) -> Odometry:
        """The present odometry, with its noise and drift: pose and velocity."""
        return self._measured(timekeeper.nanoseconds)

    def read_ground_truth(self, timekeeper: Timekeeper) -> Odometry:
        """The true pose in the world, and the true velocity."""
        return self._truth()

    def get_state(self) -> None:
        """Nothing: the core saves commands, velocities and the drift."""

    def _publish(self, nanoseconds: int) -> Odometry:
        """Publishes on the topics that have subscribers, and returns the odometry with errors."""
        estimate = self._measured(nanoseconds)
        if self._twist is not None and self._twist.has_subscribers:
            self._twist.write(self._twist_writer, nanoseconds, estimate.velocity)
        if self._odom is not None and self._odom.has_subscribers:
            self._write(self._odom, self._odom_writer, nanoseconds, estimate)
        if self._ground_truth is not None and self._ground_truth.has_subscribers:
            self._write(self._ground_truth, self._ground_truth_writer, nanoseconds, self._truth())
        return estimate

    def _measured(self, nanoseconds: int) -> Odometry:
        """The odometry with its drift, and with the noise of a time [ns]."""
        drifted = self._body.pose if self._drift is None else Pose(*self._drift.pose)
        velocity = Velocity(*self._body.physics_body.local_velocity)
        if not self._is_noisy:
            return Odometry(drifted, velocity)
        noise = (self._noise.at(nanoseconds).standard_normal(6) * self._deviation).tolist()
        x, y, yaw = (value + error for value, error in zip(drifted, noise))
        vx, vy, omega = (value + error for value, error in zip(velocity, noise[3:]))
        return Odometry(Pose(x, y, wrap_angle(yaw)), Velocity(vx, vy, omega))

    def _truth(self) -> Odometry:
        return Odometry(self._body.pose, Velocity(*self._body.physics_body.local_velocity))

    def _write(
        self,
        publisher: Publisher,
        writer: OdometryWriter,
        nanoseconds: int,
        odometry: Odometry,
    ) -> None:
        pose, twist = odometry.pose, tuple(odometry.velocity)
        if not self._odometry_config.twist_in_local_frame:
            vx, vy, omega = twist
            cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
            twist = (cos * vx - sin * vy, sin * vx + cos * vy, omega)
        publisher.write(writer, nanoseconds, pose, twist)
