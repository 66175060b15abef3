"""Odometry: the estimated pose and the measured velocity of a wheeled robot, and the true ones."""

from functools import partial
from typing import List, Optional, Sequence, Tuple

import numpy as np

from flatland_plugins.odometry_config import OdometryConfig
from flatland_plugins.odometry_writer import (
    MotionWriter,
    Odometry,
    odometry_maker,
    twist_maker,
)
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

    def open_odometry(
        self, body: ModelBody, config: OdometryConfig, period: float, slips: bool = False
    ) -> None:
        """Opens the topics, after `read_frames`.

        Args:
            body: body with the origin that is tracked.
            config: topics, noise and drift.
            period: between two messages [s]; 0 if every step has one.
            slips: whether the wheels of a drive of the body may slip: they are what is measured.
        """
        self._body = body
        self._noise = TimedNoise(self.rng)
        self._drift: Optional[Drift] = None
        if config.drift or slips:
            key = draw_key(self.rng) if config.drift else 0
            self._drift = config.drift.add_to(body, key, period)
        base_frame = self.name_space_tf(body.name)
        self._deviation = np.sqrt([*config.pose_noise, *config.twist_noise])
        self._is_noisy = bool(self._deviation.any())
        truth = self._motion = RelativePoses(None, [body.physics_body])
        if self._drift:
            self._motion = RelativePoses(None, [body.physics_body], self._drift)
        estimated = self._motion, partial(_motion_of, body, self._drift)
        self._outputs: List[Tuple[Publisher, MotionWriter]] = []
        self._ground_truth: Optional[Publisher] = None
        if config.enable_odom_pub:
            odom = self.node.advertise(config.odom_pub, "nav_msgs/Odometry")
            self._ground_truth = self.node.advertise(config.ground_truth_pub, "nav_msgs/Odometry")
            for publisher, frame, values in (
                (odom, self._odom_frame, estimated),
                (self._ground_truth, self._ground_truth_frame, (truth, partial(_motion_of, body))),
            ):
                make = odometry_maker(
                    frame, base_frame, config.pose_covariance, config.twist_covariance
                )
                writer = MotionWriter(make, *values, config.twist_in_local_frame)
                self._outputs.append((publisher, writer))
        if config.enable_twist_pub:
            publisher = self.node.advertise(
                config.twist_pub, "geometry_msgs/TwistWithCovarianceStamped"
            )
            make = twist_maker(base_frame, config.twist_covariance)
            self._outputs.insert(0, (publisher, MotionWriter(make, *estimated)))  # sent first
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
        estimate = self._publish(now)
        if self._heard_frame is not None:
            self._heard_frame.send(now, [estimate.pose] if estimate else self._motion)

    def publish_now(self, timekeeper: Timekeeper) -> None:
        """Publishes the present pose and velocity."""
        self._find_subscribers()
        self._publish(timekeeper.nanoseconds)

    def read(self, timekeeper: Timekeeper) -> Odometry:
        """The present odometry, with its noise and drift: pose and velocity."""
        return self._measured(timekeeper.nanoseconds)

    def read_ground_truth(self, timekeeper: Timekeeper) -> Odometry:
        """The true pose in the world, and the true velocity."""
        return _motion_of(self._body)

    def get_state(self) -> None:
        """Nothing: the core saves commands, velocities and the drift."""

    def _publish(self, nanoseconds: int) -> Optional[Odometry]:
        """Publishes on the topics that have subscribers; returns the odometry if it has noise."""
        estimate = self._measured(nanoseconds) if self._is_noisy else None
        for publisher, writer in self._heard:
            if estimate is None or publisher is self._ground_truth:
                publisher.write(writer, nanoseconds)
            else:
                publisher.write(writer, nanoseconds, estimate)
        return estimate

    def _find_subscribers(self) -> None:
        """Finds the topics that have subscribers; `has_work` is called when these change."""
        self._heard = [each for each in self._outputs if each[0].has_subscribers]
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


def _motion_of(body: ModelBody, drift: Optional[Drift] = None) -> Odometry:
    """The motion of a body, or what its drift makes of it."""
    if drift is None:
        return Odometry(body.pose, Velocity(*body.physics_body.local_velocity))
    return Odometry(Pose(*drift.pose), Velocity(*drift.velocity))
