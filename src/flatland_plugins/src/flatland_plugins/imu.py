"""Imu: what gyroscopes and accelerometers in a body measure, and its orientation."""

import math
from typing import Any, Dict, NamedTuple, Optional, Sequence, Tuple

import numpy as np
from geometry_msgs.msg import Quaternion, Vector3
from sensor_msgs.msg import Imu as ImuMessage

from flatland_plugins.imu_config import QUANTITIES, ImuConfig
from flatland_plugins.sensor_frame import SensorFrame
from flatland_plugins.timed_noise import TimedNoise
from flatland_server import (
    ModelPlugin,
    Timekeeper,
    UpdateTimer,
    YamlReader,
    header,
    quaternion,
    wrap_angle,
)


class Motion(NamedTuple):
    """The motion of a body's origin in the world at a time: ns, m/s, rad/s, rad."""

    nanoseconds: int
    vx: float
    vy: float
    omega: float
    yaw: float


class Imu(ModelPlugin):
    """Publishes sensor_msgs/Imu, with noise and without, for the end of steps.

    The acceleration is the mean since the message before, so that accelerations times the intervals
    between their stamps add up to the change of velocity. It is the mean over the last step in the
    first message, in the first one after a time without subscribers, and in the first one after the
    model was moved, which stops it at once. A velocity that another plugin sets in such a step is
    measured if that plugin comes after this one in the model's file. At rest, z is gravity (REP
    145).
    """

    only_publishes = True

    def on_initialize(self, config: YamlReader) -> None:
        """Reads the keys and opens the topics."""
        self._body = self.get_body(config)
        imu = self._config = ImuConfig.read(config)
        self._deviations = np.sqrt(imu.noises).ravel()
        self._noise = TimedNoise(self.rng)
        # A sensor frame with the name of the body's frame is that frame: no transform.
        is_own = self.name_space_tf(imu.imu_frame_id) == self.name_space_tf(self._body.name)
        self._frame = SensorFrame(
            self, self._body, imu.imu_frame_id, imu.broadcast_tf and not is_own
        )
        self.update_timer = UpdateTimer(imu.pub_rate)
        self._period = self.update_timer.period * 1e9  # ns
        topics = (imu.imu_pub, imu.ground_truth_pub) if imu.enable_imu_pub else ()
        self._publishers = [self.node.advertise(topic, ImuMessage) for topic in topics]
        self._start: Optional[Motion] = None
        self._end: Optional[Motion] = None  # of the time of the last message
        self._move_revision = self.model.move_revision

    def has_work(self) -> bool:
        """Whether a topic or the frame has a subscriber."""
        return self._frame.has_subscribers or self._has_subscribers()

    def before_physics_step(self, timekeeper: Timekeeper) -> None:
        """Finds the start of the time that the acceleration is measured over, if it is."""
        self._start = self._find_start(timekeeper) if self._has_subscribers() else None

    def after_physics_step(self, timekeeper: Timekeeper) -> None:
        """Publishes the transform and what is measured."""
        now = timekeeper.nanoseconds
        self._frame.publish(now)
        if self._start is None:
            return
        end = self._end = self._motion(now)
        ax, ay = mean_acceleration(self._start, end)
        truth = np.array([0, 0, end.yaw, 0, 0, end.omega, ax, ay, self._config.gravity])
        for publisher, deviations in zip(self._publishers, (self._deviations, np.zeros(9))):
            if publisher.has_subscribers:
                values = truth
                if deviations.any():
                    values = truth + self._noise.at(now).standard_normal(9) * deviations
                publisher.publish(self._message(now, values.tolist()))

    def get_state(self) -> Dict[str, Any]:
        """The motion at the last message."""
        return {"end": self._end, "move_revision": self._move_revision}

    def set_state(self, state: Dict[str, Any]) -> None:
        """Sets what `get_state` has returned."""
        self._end = Motion(*state["end"]) if state["end"] is not None else None
        self._move_revision = state["move_revision"]

    def _has_subscribers(self) -> bool:
        return any(publisher.has_subscribers for publisher in self._publishers)

    def _find_start(self, timekeeper: Timekeeper) -> Motion:
        """The motion at the last message, unless the model was moved or messages left out since."""
        now, last = timekeeper.nanoseconds, self._end
        has_moved = self.model.move_revision != self._move_revision
        self._move_revision = self.model.move_revision
        if last is None or has_moved or now - last.nanoseconds > self._period:
            return self._motion(now)
        return last

    def _motion(self, nanoseconds: int) -> Motion:
        body = self._body
        return Motion(nanoseconds, *body.physics_body.velocity, body.pose.yaw)

    def _message(self, nanoseconds: int, values: Sequence[float]) -> ImuMessage:
        message = ImuMessage(header=header(nanoseconds, self._frame.name))
        roll, pitch, yaw = values[:3]
        message.orientation = Quaternion(*quaternion(yaw, roll, pitch))
        message.angular_velocity = Vector3(*values[3:6])
        message.linear_acceleration = Vector3(*values[6:])
        for quantity, covariance in zip(QUANTITIES, self._config.covariances):
            setattr(message, f"{quantity}_covariance", covariance)
        return message


def mean_acceleration(start: Motion, end: Motion) -> Tuple[float, float]:
    """Forwards and to the left [m/s^2], between two times, in the body's frame halfway through.

    On a circle the velocity turns by omega dt, and its change points inwards where the body was
    halfway; it is shorter than the arc by (omega dt)^2 / 24 of it. A body turns by less than pi.
    """
    dt = (end.nanoseconds - start.nanoseconds) * 1e-9
    halfway = start.yaw + wrap_angle(end.yaw - start.yaw) / 2
    cos, sin = math.cos(halfway), math.sin(halfway)
    ax, ay = (end.vx - start.vx) / dt, (end.vy - start.vy) / dt
    return cos * ax + sin * ay, cos * ay - sin * ax
