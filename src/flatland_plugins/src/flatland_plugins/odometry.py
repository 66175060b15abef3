"""Odometry: the estimated pose and the measured velocity of a wheeled robot, and the true ones."""

import math
from typing import Any, Dict, List, NamedTuple, Optional

import numpy as np

from flatland_plugins.odometry_config import OdometryConfig, OdometryFrames
from flatland_plugins.odometry_drift import OdometryDrift
from flatland_plugins.odometry_writer import OdometryWriter, TwistWriter
from flatland_plugins.timed_noise import TimedNoise, draw_key
from flatland_server import Frames, ModelBody, ModelPlugin, Pose, Publisher, Velocity, wrap_angle


class Odometry(NamedTuple):
    """Pose and velocity of a body."""

    pose: Pose
    """In the frame of odometry, or in the world."""
    velocity: Velocity
    """In the frame of the body."""


class OdometryPublisher:
    """Publishes a body's odometry with errors, the ground truth, its twist and its transform.

    Drift and the noise of the pose are in the odometry and the transform, the noise of the velocity
    is in the odometry and the twist. If a model is moved, its odometry moves with it.

    Args:
        plugin: the drive.
        body: the body; its origin is tracked.
        frames: of the poses.
        config: topics, noise and drift.
    """

    def __init__(
        self, plugin: ModelPlugin, body: ModelBody, frames: OdometryFrames, config: OdometryConfig
    ) -> None:
        self._config = config
        self._model = plugin.model
        self._body = body
        self._node = plugin.node
        self._noise = TimedNoise(plugin.rng)
        self._drift: Optional[OdometryDrift] = None
        self._move_revision = self._model.move_revision
        if config.drift:
            self._drift = OdometryDrift(config.drift, draw_key(plugin.rng))
        self._base_frame = plugin.name_space_tf(body.name)
        self._deviation = np.sqrt([*config.pose_noise, *config.twist_noise])
        self._is_noisy = bool(self._deviation.any())
        self._odom: Optional[Publisher] = None
        self._ground_truth: Optional[Publisher] = None
        self._twist: Optional[Publisher] = None
        if config.enable_odom_pub:
            self._odom = self._node.advertise(config.odom_pub, "nav_msgs/Odometry")
            self._ground_truth = self._node.advertise(config.ground_truth_pub, "nav_msgs/Odometry")
        if config.enable_twist_pub:
            self._twist = self._node.advertise(
                config.twist_pub, "geometry_msgs/TwistWithCovarianceStamped"
            )
        self._odom_writer, self._ground_truth_writer = (
            OdometryWriter(
                frame_id, self._base_frame, config.pose_covariance, config.twist_covariance
            )
            for frame_id in frames
        )
        self._twist_writer = TwistWriter(self._base_frame, config.twist_covariance)
        self._frame: Optional[Frames] = None
        if config.enable_odom_tf_pub:
            self._frame = self._node.open_frames((frames.odom, self._base_frame))
            if frames.odom != frames.ground_truth:  # all models share the world's frame
                self._node.claim_odometry_frame(frames.odom)

    def has_work(self) -> bool:
        """Whether `publish` does anything: there is a subscriber, or a drift to accumulate."""
        return self._drift is not None or self._has_subscribers()

    def publish(self, nanoseconds: int) -> None:
        """Publishes the present pose and velocity on the topics that have subscribers.

        Call it whenever odometry is due, with or without subscribers: drift accumulates.
        """
        pose = self._body.pose
        if self._drift is not None:
            has_jumped = self._model.move_revision != self._move_revision
            self._move_revision = self._model.move_revision
            self._drift.advance(nanoseconds, pose, has_jumped=has_jumped)
            if not self._has_subscribers():
                return
        estimate = self._publish(nanoseconds, pose if self._drift is None else self._drift.pose)
        if self._frame is not None and self._node.transforms_have_subscribers:
            self._frame.send(nanoseconds, [estimate.pose])

    def publish_now(self, nanoseconds: int) -> None:
        """Publishes the present pose and velocity; does not advance the drift."""
        self._publish(nanoseconds, self._drifted(nanoseconds))

    def read(self, nanoseconds: int) -> Odometry:
        """The estimated pose and the measured velocity at the present time [ns]."""
        return self._measured(nanoseconds, self._drifted(nanoseconds))

    def read_ground_truth(self) -> Odometry:
        """The true pose and velocity."""
        return Odometry(self._body.pose, Velocity(*self._body.physics_body.local_velocity))

    def _publish(self, nanoseconds: int, drifted: Pose) -> Odometry:
        """Publishes on the topics that have subscribers, and returns the odometry with errors."""
        estimate = self._measured(nanoseconds, drifted)
        if self._twist is not None and self._twist.has_subscribers:
            self._twist.write(self._twist_writer, nanoseconds, estimate.velocity)
        if self._odom is not None and self._odom.has_subscribers:
            self._write(self._odom, self._odom_writer, nanoseconds, estimate)
        if self._ground_truth is not None and self._ground_truth.has_subscribers:
            truth = self.read_ground_truth()
            self._write(self._ground_truth, self._ground_truth_writer, nanoseconds, truth)
        return estimate

    def _measured(self, nanoseconds: int, drifted: Pose) -> Odometry:
        """The odometry of a pose that has drifted, with the noise of a time [ns]."""
        velocity = Velocity(*self._body.physics_body.local_velocity)
        if not self._is_noisy:
            return Odometry(drifted, velocity)
        noise = self._noise_at(nanoseconds)
        x, y, yaw = (value + error for value, error in zip(drifted, noise))
        vx, vy, omega = (value + error for value, error in zip(velocity, noise[3:]))
        return Odometry(Pose(x, y, wrap_angle(yaw)), Velocity(vx, vy, omega))

    def _drifted(self, nanoseconds: int) -> Pose:
        """The estimated pose at the present time [ns]; does not advance the drift."""
        pose = self._body.pose
        if self._drift is None:
            return pose
        has_jumped = self._model.move_revision != self._move_revision
        return self._drift.preview(nanoseconds, pose, has_jumped=has_jumped)

    def get_state(self) -> Dict[str, Any]:
        """The drift and the number of the last move, for a saved state."""
        drift = self._drift.get_state() if self._drift is not None else None
        return {"drift": drift, "move_revision": self._move_revision}

    def set_state(self, state: Dict[str, Any]) -> None:
        """Restores a state that `get_state` has returned."""
        self._move_revision = state["move_revision"]
        if self._drift is not None:
            self._drift.set_state(state["drift"])

    def _has_subscribers(self) -> bool:
        if self._frame is not None and self._node.transforms_have_subscribers:
            return True
        publishers = (self._twist, self._odom, self._ground_truth)
        return any(publisher is not None and publisher.has_subscribers for publisher in publishers)

    def _noise_at(self, nanoseconds: int) -> List[float]:
        """The errors of the pose and the velocity."""
        normal = self._noise.at(nanoseconds).standard_normal(6)
        noise: List[float] = (normal * self._deviation).tolist()
        return noise

    def _write(
        self,
        publisher: Publisher,
        writer: OdometryWriter,
        nanoseconds: int,
        odometry: Odometry,
    ) -> None:
        pose, twist = odometry.pose, tuple(odometry.velocity)
        if not self._config.twist_in_local_frame:
            vx, vy, omega = twist
            cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
            twist = (cos * vx - sin * vy, sin * vx + cos * vy, omega)
        publisher.write(writer, nanoseconds, pose, twist)
