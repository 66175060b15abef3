"""Odometry: the estimated pose and the measured velocity of a wheeled robot, and the true ones."""

import math
from functools import partial
from typing import List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from flatland_plugins.odometry_config import OdometryConfig
from flatland_plugins.odometry_writer import BodyWriter, OdometryWriter, Twist, TwistWriter
from flatland_plugins.timed_noise import TimedNoise, draw_key
from flatland_server import (
    Drift,
    Frames,
    ModelBody,
    ModelPlugin,
    Pose,
    Publisher,
    RelativePoses,
    StepMessage,
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

    Drift is in all but the ground truth: the velocity is the one that the wheels measure, and the
    pose its integral. The noise of the pose is in the odometry and the transform, that of the
    velocity in the odometry and the twist. If a model is moved, its odometry moves with it.
    """

    quantities = ("ground_truth",)

    def read_frames(self, config: YamlReader) -> None:
        """Reads the frames of the estimated and of the true poses."""
        self._odom_frame = self.get_frame_id(config, "odom_frame_id", "odom")
        self._ground_truth_frame = self.get_frame_id(config, "ground_truth_frame_id", "map")
        is_own = self._odom_frame.startswith(f"{self.node.namespace}_")
        is_true = self._odom_frame == self._ground_truth_frame
        if self.model.has_own_frames and not (is_own or is_true):
            self._odom_frame = self.name_space_tf(self._odom_frame)

    def open_odometry(self, body: ModelBody, config: OdometryConfig, period: float) -> None:
        """Opens the topics, after `read_frames`.

        Args:
            body: its origin is tracked.
            config: topics, noise and drift.
            period: between two messages [s]; 0 if every step has one.
        """
        self._odometry_config = config
        self._body = body
        self._noise = TimedNoise(self.rng)
        self._drift = (
            config.drift.add_to(body, draw_key(self.rng), period) if config.drift else None
        )
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
        self._odom_writer, ground_truth_writer = (
            OdometryWriter(frame, base_frame, *covariances)
            for frame in (self._odom_frame, self._ground_truth_frame)
        )
        self._twist_writer = TwistWriter(base_frame, config.twist_covariance)
        truth = RelativePoses(None, [body.physics_body])
        motion = self._motion = (
            RelativePoses(None, [body.physics_body], self._drift) if self._drift else truth
        )
        is_local = config.twist_in_local_frame
        self._exact_odom_writer, self._ground_truth_writer = (
            BodyWriter(
                writer,
                poses,
                partial(_values_of, self._body, drift, is_local),
                twist_in_local_frame=is_local,
            )
            for writer, poses, drift in (
                (self._odom_writer, motion, self._drift),
                (ground_truth_writer, truth, None),
            )
        )
        self._exact_twist_writer = BodyWriter(
            self._twist_writer, motion, partial(_twist_of, self._body, self._drift)
        )
        self._frame: Optional[Frames] = None
        if config.enable_odom_tf_pub:
            self._frame = self.node.open_frames((self._odom_frame, base_frame))
            if self._odom_frame != self._ground_truth_frame:  # all models share the world's frame
                self.node.claim_odometry_frame(self._odom_frame)
        self._find_subscribers()

    def has_work(self) -> bool:
        """True if the odometry has a subscriber."""
        self._find_subscribers()
        return bool(self._heard or self._heard_frame)

    def step_messages(self) -> Sequence[Optional[StepMessage]]:
        """All messages, unless they have noise."""
        if self._is_noisy:
            return ()
        messages = [publisher.step_message(each.body_message) for publisher, each in self._heard]
        if self._heard_frame is not None:
            messages.append(self._heard_frame.step_message(self._motion))
        return messages

    def before_physics_step(self, timekeeper: Timekeeper) -> None:
        """Publishes odometry on the topics that have subscribers."""
        now = timekeeper.nanoseconds
        if not self._is_noisy:
            self._publish_exact(now)
            if self._heard_frame is not None:
                self._heard_frame.send(now, self._motion)
            return
        estimate = self._publish(now)
        if self._heard_frame is not None:
            self._heard_frame.send(now, [estimate.pose])

    def publish_now(self, timekeeper: Timekeeper) -> None:
        """Publishes the present pose and velocity."""
        self._find_subscribers()
        if self._is_noisy:
            self._publish(timekeeper.nanoseconds)
        else:
            self._publish_exact(timekeeper.nanoseconds)

    def read(self, timekeeper: Timekeeper) -> Odometry:
        """The present odometry, with its noise and drift: pose and velocity."""
        return self._measured(timekeeper.nanoseconds)

    def read_ground_truth(self, timekeeper: Timekeeper) -> Odometry:
        """The true pose in the world, and the true velocity."""
        return _motion_of(self._body, None)

    def get_state(self) -> None:
        """Nothing: the core saves commands, velocities and the drift."""

    def _publish_exact(self, nanoseconds: int) -> None:
        """Publishes what the core reads, without noise, on the topics that have subscribers."""
        for publisher, writer in self._heard:
            publisher.write(writer, nanoseconds)

    def _publish(self, nanoseconds: int) -> Odometry:
        """Publishes on the topics that have subscribers, and returns the odometry with errors."""
        estimate = self._measured(nanoseconds)
        for publisher, writer in self._heard:
            if publisher is self._twist:
                publisher.write(self._twist_writer, nanoseconds, estimate.velocity)
            elif publisher is self._odom:
                is_local = self._odometry_config.twist_in_local_frame
                publisher.write(self._odom_writer, nanoseconds, *_values(estimate, is_local))
            else:
                publisher.write(writer, nanoseconds)
        return estimate

    def _find_subscribers(self) -> None:
        """Finds the topics that have subscribers; `has_work` is called when these change."""
        outputs = (
            (self._twist, self._exact_twist_writer),
            (self._odom, self._exact_odom_writer),
            (self._ground_truth, self._ground_truth_writer),
        )
        self._heard: List[Tuple[Publisher, BodyWriter]] = [
            (publisher, writer)
            for publisher, writer in outputs
            if publisher is not None and publisher.has_subscribers
        ]
        self._heard_frame = self._frame if self.node.transforms_have_subscribers else None

    def _measured(self, nanoseconds: int) -> Odometry:
        """The odometry with its drift, and with the noise of a time [ns]."""
        pose, velocity = measured = _motion_of(self._body, self._drift)
        if not self._is_noisy:
            return measured
        noise = (self._noise.at(nanoseconds).standard_normal(6) * self._deviation).tolist()
        x, y, yaw = (value + error for value, error in zip(pose, noise))
        vx, vy, omega = (value + error for value, error in zip(velocity, noise[3:]))
        return Odometry(Pose(x, y, wrap_angle(yaw)), Velocity(vx, vy, omega))


# Functions of the body alone: a writer that keeps the plugin would make a cycle of references.


def _motion_of(body: ModelBody, drift: Optional[Drift]) -> Odometry:
    """The motion of a body, or what its drift makes of it."""
    if drift is None:
        return Odometry(body.pose, Velocity(*body.physics_body.local_velocity))
    return Odometry(Pose(*drift.pose), Velocity(*drift.velocity))


def _twist_of(body: ModelBody, drift: Optional[Drift]) -> Tuple[Twist]:
    return (_motion_of(body, drift).velocity,)


def _values_of(body: ModelBody, drift: Optional[Drift], is_local: bool) -> Tuple[Pose, Twist]:
    return _values(_motion_of(body, drift), is_local)


def _values(odometry: Odometry, is_local: bool) -> Tuple[Pose, Twist]:
    """The pose and the twist of a message."""
    pose, twist = odometry
    if is_local:
        return pose, twist
    vx, vy, omega = twist
    cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
    return pose, (cos * vx - sin * vy, sin * vx + cos * vy, omega)
