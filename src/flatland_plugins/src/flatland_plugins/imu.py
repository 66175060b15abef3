"""Imu: readings of gyroscopes and accelerometers in a body, and its orientation."""

import math
from typing import Any, Dict, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from flatland_plugins.imu_config import QUANTITIES, ImuConfig
from flatland_plugins.sensor_frame import SensorFrame, static_by_default
from flatland_plugins.timed_noise import TimedNoise
from flatland_server import (
    BatchRole,
    FloatArray,
    ModelPlugin,
    Timekeeper,
    UpdateTimer,
    YamlReader,
    header,
    messages,
    quaternion,
    wrap_angle,
)

ImuMessage = messages.get("sensor_msgs/Imu")
Quaternion = messages.get("geometry_msgs/Quaternion")
Vector3 = messages.get("geometry_msgs/Vector3")


_EXACT = np.zeros(9)
"""No noise."""


class Motion(NamedTuple):
    """The motion of a body's origin in the world at a time: ns, m/s, rad/s, rad."""

    nanoseconds: int
    vx: float
    vy: float
    omega: float
    yaw: float


class ImuReading(NamedTuple):
    """The quantities that an Imu measures, in the body's frame: x forwards, y to the left, z up."""

    orientation: Tuple[float, float, float]
    """Roll, pitch and yaw in the world [rad]."""
    angular_velocity: Tuple[float, float, float]
    """[rad/s]"""
    linear_acceleration: Tuple[float, float, float]
    """[m/s^2]"""


class Imu(ModelPlugin):
    """Publishes sensor_msgs/Imu, with noise and without, for the end of steps.

    The acceleration is the mean since the message before, so that accelerations times the intervals
    between their stamps add up to the change of velocity. It is the mean over the last step in the
    first message, in the first one after a time without subscribers, and in the first one after the
    model was moved, which stops it at once. A velocity that another plugin sets in such a step is
    measured if that plugin comes after this one in the model's file. At rest, z is gravity (REP
    145).
    """

    batch_role = BatchRole()

    quantities = ("ground_truth",)

    def on_initialize(self, config: YamlReader) -> None:
        self._body = self.get_body(config)
        imu = self._config = ImuConfig.read(config, static_by_default(self))
        self._deviations = np.sqrt(imu.noises).ravel()
        self._noise = TimedNoise(self.rng)
        # A sensor frame with the name of the body's frame is that frame: no transform.
        is_own = self.name_space_tf(imu.imu_frame_id) == self.name_space_tf(self._body.name)
        tf_topic = None if is_own else imu.tf_topic
        self._frame = SensorFrame(self, self._body, imu.imu_frame_id, tf_topic)
        self.update_timer = UpdateTimer(imu.pub_rate)
        self._period = self.update_timer.period * 1e9  # ns
        topics = (imu.imu_pub, imu.ground_truth_pub) if imu.enable_imu_pub else ()
        self._publishers = [self.node.advertise(topic, "sensor_msgs/Imu") for topic in topics]
        self._start: Optional[Motion] = None
        self._end: Optional[Motion] = None  # at the last message
        self._move_revision = self.model.move_revision
        self._reading: Optional[Tuple[Motion, Motion]] = None  # start and end of the last reading
        self._reading_revision = self._move_revision

    @property
    def frame_id(self) -> str:
        """The frame of its messages."""
        return self._frame.name

    def has_work(self) -> bool:
        """True if a topic or the frame has a subscriber."""
        return self._frame.has_subscribers or self._has_subscribers()

    def before_physics_step(self, timekeeper: Timekeeper) -> None:
        """Finds the start of the acceleration's interval, if there are subscribers."""
        self._start = self._find_start(timekeeper) if self._has_subscribers() else None

    def after_physics_step(self, timekeeper: Timekeeper) -> None:
        """Publishes the transform and the measurement."""
        now = timekeeper.nanoseconds
        self._frame.publish(now)
        if self._start is None:
            return
        self._end = self._motion(now)
        self._publish(self._start, self._end)

    def publish_now(self, timekeeper: Timekeeper) -> None:
        self._publish(*self._find_reading(timekeeper.nanoseconds))

    def read(self, timekeeper: Timekeeper) -> ImuReading:
        """The present measurement, with noise.

        The acceleration is that of the message of this time, if there is one; or else the mean
        since the last message or reading, and 0 in the first one and after the model was moved.
        """
        start, end = self._find_reading(timekeeper.nanoseconds)
        return _reading(self._measure(start, end, self._deviations))

    def read_ground_truth(self, timekeeper: Timekeeper) -> ImuReading:
        """The present measurement, without noise."""
        return _reading(self._measure(*self._find_reading(timekeeper.nanoseconds), _EXACT))

    def get_state(self) -> Dict[str, Any]:
        """The motions at the last message and the last reading."""
        return {
            "end": self._end,
            "move_revision": self._move_revision,
            "start": self._start,
            "reading": self._reading,
            "reading_revision": self._reading_revision,
        }

    def set_state(self, state: Dict[str, Any]) -> None:
        self._end = Motion(*state["end"]) if state["end"] is not None else None
        self._move_revision = state["move_revision"]
        self._start = Motion(*state["start"]) if state["start"] is not None else None
        self._reading = None
        if state["reading"] is not None:
            start, end = state["reading"]
            self._reading = Motion(*start), Motion(*end)
        self._reading_revision = state["reading_revision"]

    def _publish(self, start: Motion, end: Motion) -> None:
        for publisher, deviations in zip(self._publishers, (self._deviations, _EXACT)):
            if publisher.has_subscribers:
                values = self._measure(start, end, deviations)
                publisher.publish(self._message(end.nanoseconds, values))

    def _measure(self, start: Motion, end: Motion, deviations: FloatArray) -> List[float]:
        """Roll, pitch and yaw, three angular velocities and three accelerations."""
        ax, ay = mean_acceleration(start, end)
        values = np.array([0, 0, end.yaw, 0, 0, end.omega, ax, ay, self._config.gravity])
        if deviations.any():
            values += self._noise.at(end.nanoseconds).standard_normal(9) * deviations
        measured: List[float] = values.tolist()
        return measured

    def _find_reading(self, now: int) -> Tuple[Motion, Motion]:
        """Motions at the start and end of the present reading; equal ones give no acceleration."""
        if self._start is not None and self._end is not None and self._end.nanoseconds == now:
            return self._start, self._end  # a message has been published
        if self._reading is None or self._reading[1].nanoseconds != now:
            start = end = self._motion(now)
            before = [each for each in (self._reading and self._reading[1], self._end) if each]
            revision = self.model.move_revision
            if before and revision == self._reading_revision == self._move_revision:
                start = max(before)
            self._reading, self._reading_revision = (start, end), revision
        return self._reading

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

    def _message(self, nanoseconds: int, values: Sequence[float]) -> Any:
        message = ImuMessage(header=header(nanoseconds, self._frame.name))
        roll, pitch, yaw = values[:3]
        message.orientation = Quaternion(*quaternion(yaw, roll, pitch))
        message.angular_velocity = Vector3(*values[3:6])
        message.linear_acceleration = Vector3(*values[6:])
        for quantity, covariance in zip(QUANTITIES, self._config.covariances):
            setattr(message, f"{quantity}_covariance", covariance)
        return message


def _reading(values: Sequence[float]) -> ImuReading:
    roll, pitch, yaw, wx, wy, wz, ax, ay, az = values
    return ImuReading((roll, pitch, yaw), (wx, wy, wz), (ax, ay, az))


def mean_acceleration(start: Motion, end: Motion) -> Tuple[float, float]:
    """The mean [m/s^2] between two times, forwards and to the left in the body's frame halfway.

    On a circle the velocity turns by omega dt, and its change points inwards where the body was
    halfway; it is shorter than the arc by (omega dt)^2 / 24 of it. A body turns by less than pi.
    Zero between equal times.
    """
    if start.nanoseconds == end.nanoseconds:
        return 0.0, 0.0
    dt = (end.nanoseconds - start.nanoseconds) * 1e-9
    halfway = start.yaw + wrap_angle(end.yaw - start.yaw) / 2
    cos, sin = math.cos(halfway), math.sin(halfway)
    ax, ay = (end.vx - start.vx) / dt, (end.vy - start.vy) / dt
    return cos * ax + sin * ay, cos * ay - sin * ax
