"""Gps: a receiver of satellite navigation."""

from typing import Any

from flatland_plugins.geodesy import Geodetic, TangentPlane
from flatland_plugins.sensor_frame import SensorFrame, read_tf_topic, static_by_default
from flatland_plugins.timed_noise import TimedNoise
from flatland_server import (
    BatchRole,
    ModelPlugin,
    Pose,
    Timekeeper,
    UpdateTimer,
    YamlReader,
    header,
    messages,
)

NavSatFix = messages.get("sensor_msgs/NavSatFix")
NavSatStatus = messages.get("sensor_msgs/NavSatStatus")


class Gps(ModelPlugin):
    """Publishes sensor_msgs/NavSatFix: the antenna's place, with the world's x east and y north.

    East and north have the noise of `noise_std_dev`, by default none, and its covariance, of the
    type "known"; the altitude has no error. Many subscribers refuse fixes of unknown covariance, or
    assume an error of their own; robot_localization's filters replace zeros by a variance of 1e-9.
    """

    batch_role = BatchRole()

    def on_initialize(self, config: YamlReader) -> None:
        self._body = self.get_body(config)
        topic = config.get_topic("topic", "gps/fix")
        update_rate = config.get_rate("update_rate", 10.0)
        tf_topic = read_tf_topic(config, static_by_default(self))
        frame = config.get_frame("frame", self.name)
        latitude = _read_degrees(config, "ref_lat", 90.0)
        longitude = _read_degrees(config, "ref_lon", 180.0)
        self._origin = config.get_pose("origin", Pose())
        self._deviation = config.get_float("noise_std_dev", 0.0, minimum=0.0)
        config.finish()

        self._plane = TangentPlane(latitude, longitude)
        self._noise = TimedNoise(self.rng) if self._deviation else None
        self._frame = SensorFrame(self, self._body, frame, tf_topic, self._origin)
        self.update_timer = UpdateTimer(update_rate)
        self._publisher = self.node.advertise(topic, "sensor_msgs/NavSatFix")

    @property
    def frame_id(self) -> str:
        """The frame of its messages."""
        return self._frame.name

    def has_work(self) -> bool:
        """True if the topic or the frame has a subscriber."""
        return self._publisher.has_subscribers or self._frame.has_subscribers

    def before_physics_step(self, timekeeper: Timekeeper) -> None:
        now = timekeeper.nanoseconds
        self._frame.publish(now)
        if self._publisher.has_subscribers:
            self._publisher.publish(self._fix(now))

    def publish_now(self, timekeeper: Timekeeper) -> None:
        self._publisher.publish(self._fix(timekeeper.nanoseconds))

    def read(self, timekeeper: Timekeeper) -> Geodetic:
        """The antenna's latitude and longitude [deg], and its altitude [m]."""
        return self._place(timekeeper.nanoseconds)

    def _place(self, nanoseconds: int) -> Geodetic:
        antenna = self._body.pose.compose(self._origin)
        if self._noise is None:
            return self._plane.to_geodetic(antenna.x, antenna.y)
        east, north = self._noise.at(nanoseconds).normal(antenna[:2], self._deviation).tolist()
        return self._plane.to_geodetic(east, north)

    def _fix(self, nanoseconds: int) -> Any:
        place = self._place(nanoseconds)
        variance = self._deviation**2
        return NavSatFix(
            header=header(nanoseconds, self._frame.name),
            status=NavSatStatus(NavSatStatus.STATUS_FIX, NavSatStatus.SERVICE_GPS),
            latitude=place.latitude,
            longitude=place.longitude,
            altitude=place.altitude,
            position_covariance=(variance, 0.0, 0.0, 0.0, variance, 0.0, 0.0, 0.0, 0.0),
            position_covariance_type=NavSatFix.COVARIANCE_TYPE_KNOWN,
        )

    def get_state(self) -> None:
        """Nothing: a fix depends on the present alone."""


def _read_degrees(config: YamlReader, key: str, limit: float) -> float:
    """An angle of the reference [deg], 0 by default, at most `limit` either way."""
    angle = config.get_float(key, 0.0)
    if abs(angle) > limit:
        config.problem(f"expected a number of {-limit:g} to {limit:g}, found {angle:.12g}", key)
    return angle
