"""Imu: what gyroscopes and accelerometers in a body measure, and its orientation."""

import math
from dataclasses import dataclass
from typing import NamedTuple, Optional, Sequence, Tuple

import numpy as np
from geometry_msgs.msg import Quaternion, Vector3
from sensor_msgs.msg import Imu as ImuMessage

from flatland_plugins.messages import header
from flatland_plugins.sensor_frame import SensorFrame
from flatland_plugins.timed_noise import TimedNoise
from flatland_server import (
    ModelPlugin,
    Timekeeper,
    UpdateTimer,
    YamlReader,
    quaternion,
    wrap_angle,
)

STANDARD_GRAVITY = 9.80665  # [m/s^2] (3rd General Conference on Weights and Measures, 1901)

# [roll, pitch, yaw] in rad, [x, y, z] in rad/s, and [x, y, z] in m/s^2
QUANTITIES = ("orientation", "angular_velocity", "linear_acceleration")


@dataclass(frozen=True)
class ImuConfig:
    """The keys, the body aside; noises (variances) and covariances in the order of QUANTITIES."""

    enable_imu_pub: bool
    imu_frame_id: str
    imu_pub: str
    ground_truth_pub: str
    noises: Tuple[Tuple[float, ...], ...]
    covariances: Tuple[Tuple[float, ...], ...]
    gravity: float
    pub_rate: float
    broadcast_tf: bool

    @classmethod
    def read(cls, config: YamlReader) -> "ImuConfig":
        """Reads the keys; `update_rate` is another name for `pub_rate`."""
        noises, covariances = [], []
        for quantity in QUANTITIES:
            noise = config.get_floats(f"{quantity}_noise", 3, (0.0, 0.0, 0.0), minimum=0.0)
            diagonal = tuple(np.diag(noise).ravel().tolist())
            noises.append(noise)
            covariances.append(config.get_floats(f"{quantity}_covariance", 9, diagonal))
        pub_rate = config.get_rate("pub_rate", math.inf)
        imu = cls(
            enable_imu_pub=config.get_bool("enable_imu_pub", True),
            imu_frame_id=config.get_string("imu_frame_id", "imu"),
            imu_pub=config.get_string("imu_pub", "imu/filtered"),
            ground_truth_pub=config.get_string("ground_truth_pub", "imu/ground_truth"),
            noises=tuple(noises),
            covariances=tuple(covariances),
            gravity=config.get_float("gravity", STANDARD_GRAVITY, minimum=0.0),
            pub_rate=config.get_rate("update_rate", pub_rate),
            broadcast_tf=config.get_bool("broadcast_tf", True),
        )
        if config.has("pub_rate") and config.has("update_rate"):
            config.problem('"pub_rate" and "update_rate" are one key: give one', "update_rate")
        config.finish()
        return imu


class Motion(NamedTuple):
    """How a body's origin moves in the world at one moment: m/s, rad/s, rad."""

    vx: float
    vy: float
    omega: float
    yaw: float


class Imu(ModelPlugin):
    """Publishes sensor_msgs/Imu, with noise and without, of the moment that a step leads to.

    The acceleration is the mean over that step, so that moving a model between two steps does not
    show. What a plugin does to the velocity before the step shows if that plugin comes after this
    one in the model's file. As REP 145 says, z is gravity in a body at rest.
    """

    def on_initialize(self, config: YamlReader) -> None:
        """Reads the keys and opens the topics."""
        self._body = self.get_body(config)
        imu = self._config = ImuConfig.read(config)
        self._deviations = np.sqrt(imu.noises).ravel()
        self._noise = TimedNoise(self.rng)
        # Measured in the body's own frame, under its name, there is nothing to transform.
        is_own = self.name_space_tf(imu.imu_frame_id) == self.name_space_tf(self._body.name)
        self._frame = SensorFrame(
            self, self._body, imu.imu_frame_id, imu.broadcast_tf and not is_own
        )
        self.update_timer = UpdateTimer(imu.pub_rate)
        topics = (imu.imu_pub, imu.ground_truth_pub) if imu.enable_imu_pub else ()
        self._publishers = [self.node.advertise(topic, ImuMessage) for topic in topics]
        self._start: Optional[Motion] = None

    def has_work(self) -> bool:
        """Whether anybody listens."""
        return self._frame.has_subscribers or self._has_subscribers()

    def before_physics_step(self, timekeeper: Timekeeper) -> None:
        """Notes how the body moves, if somebody listens already."""
        self._start = self._motion() if self._has_subscribers() else None

    def after_physics_step(self, timekeeper: Timekeeper) -> None:
        """Publishes the transform and what is measured."""
        now = timekeeper.nanoseconds
        self._frame.publish(now)
        if self._start is None:
            return
        end = self._motion()
        ax, ay = mean_acceleration(self._start, end, timekeeper.step_size)
        truth = np.array([0, 0, end.yaw, 0, 0, end.omega, ax, ay, self._config.gravity])
        for publisher, deviations in zip(self._publishers, (self._deviations, np.zeros(9))):
            if publisher.has_subscribers:
                values = truth
                if deviations.any():
                    values = truth + self._noise.at(now).standard_normal(9) * deviations
                publisher.publish(self._message(now, values.tolist()))

    def _has_subscribers(self) -> bool:
        return any(publisher.has_subscribers for publisher in self._publishers)

    def _motion(self) -> Motion:
        return Motion(*self._body.physics_body.velocity, self._body.pose.yaw)

    def _message(self, nanoseconds: int, values: Sequence[float]) -> ImuMessage:
        message = ImuMessage(header=header(nanoseconds, self._frame.name))
        roll, pitch, yaw = values[:3]
        message.orientation = Quaternion(*quaternion(yaw, roll, pitch))
        message.angular_velocity = Vector3(*values[3:6])
        message.linear_acceleration = Vector3(*values[6:])
        for quantity, covariance in zip(QUANTITIES, self._config.covariances):
            setattr(message, f"{quantity}_covariance", covariance)
        return message


def mean_acceleration(start: Motion, end: Motion, dt: float) -> Tuple[float, float]:
    """Forwards and to the left [m/s^2], over `dt` [s], in the body's frame halfway through.

    On a circle the velocity turns by omega dt, and its change points inwards where the body was
    halfway; it is shorter than the arc by (omega dt)^2 / 24 of it. A body turns by less than pi.
    """
    halfway = start.yaw + wrap_angle(end.yaw - start.yaw) / 2
    cos, sin = math.cos(halfway), math.sin(halfway)
    ax, ay = (end.vx - start.vx) / dt, (end.vy - start.vy) / dt
    return cos * ax + sin * ay, cos * ay - sin * ax
