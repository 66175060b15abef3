"""Laser: a planar lidar on a body."""

import math
import struct
from functools import lru_cache
from typing import Any, Tuple

import numpy as np

from flatland_plugins.laser_config import LaserConfig
from flatland_plugins.sensor_frame import SensorFrame, static_by_default
from flatland_plugins.timed_noise import draw_key
from flatland_server import (
    BatchRole,
    BeamFan,
    Canvas,
    CoreLidar,
    Float32Array,
    FloatArray,
    MessageWriter,
    ModelPlugin,
    Pose,
    RangeNoise,
    Timekeeper,
    UpdateTimer,
    YamlReader,
    header,
    messages,
    stamp_of,
)

LaserScan = messages.get("sensor_msgs/LaserScan")

REFLECTANCE_LAYER = "reflectance"
"""Name of the layer on which walls and footprints return an intensity of 255."""

_CONSTANT_FIELDS = (
    *("angle_min", "angle_max", "angle_increment"),
    *("time_increment", "scan_time", "range_min", "range_max"),
)
"""Of a LaserScan, in the order of the message."""

_BEAMS = (0.8, 0.0, 0.0, 0.08)
_RETURNS = (0.8, 0.0, 0.0, 1.0)


class Laser(ModelPlugin):
    """Publishes sensor_msgs/LaserScan; scans only if the topic has a subscriber."""

    quantities = ("intensities",)

    def on_initialize(self, config: YamlReader) -> None:
        body = self._body = self.get_body(config)
        ignored = self.get_body_names(config, "ignore_bodies")
        laser = self._config = config.read_once(
            LaserConfig.read,
            self.name,
            self.node.get_param("~no_return", "inf"),
            static_by_default(self),
        )
        registry = self.model.registry
        try:
            layers = registry.bits(laser.layers)
        except ValueError as error:
            raise config.error(str(error), "layers") from None
        has_reflectance = REFLECTANCE_LAYER in registry.names
        reflectance = registry.bits([REFLECTANCE_LAYER]) if has_reflectance else 0
        self._is_noisy = laser.noise_std_dev > 0.0
        self._add_noise = self._make_noise(self.rng)
        # Mounted upside down, the lidar turns about the downward axis: its beams go the other way.
        handedness = self._handedness = -1.0 if laser.upside_down else 1.0
        fan = _fan(handedness * laser.angle_min, handedness * laser.increment, laser.beams)
        self._lidar = body.physics_body.add_lidar(
            fan,
            laser.origin,
            laser.range,
            layers,
            reflectance,
            laser.range_min,
            [self.model.get_body(name).physics_body for name in sorted(ignored)],
        )
        roll = math.pi if laser.upside_down else 0.0
        self._frame = SensorFrame(self, body, laser.frame, laser.tf_topic, laser.origin, roll)
        self.update_timer = UpdateTimer(laser.update_rate)
        self._publisher = self.node.advertise(laser.topic, LaserScan)
        self._writer = ScanWriter(
            self._frame.name,
            angle_min=laser.angle_min,
            angle_max=laser.angle_min + (laser.beams - 1) * laser.increment,
            angle_increment=laser.increment,
            scan_time=self.update_timer.period,
            range_min=laser.range_min,
            range_max=laser.range,
        )

    def _make_noise(self, rng: np.random.Generator) -> RangeNoise:
        laser = self._config
        return RangeNoise(draw_key(rng), laser.noise_std_dev, laser.range, laser.range_min)

    @property
    def batch_role(self) -> BatchRole:
        """The lidar, with its noise."""
        make_noise = self._make_noise if self._is_noisy else None
        return BatchRole(lidar=CoreLidar(self._lidar, self._config.range, make_noise))

    @property
    def angles(self) -> FloatArray:
        """The directions of the beams in the lidar's frame [rad]: a new array (n,)."""
        laser = self._config
        return laser.angle_min + laser.increment * np.arange(laser.beams)

    @property
    def origin(self) -> Pose:
        """Its place on its body: x, y [m] and yaw [rad]."""
        return self._config.origin

    @property
    def range_max(self) -> float:
        """The largest distance that it measures [m]."""
        return self._config.range

    @property
    def frame_id(self) -> str:
        """The frame of its messages."""
        return self._frame.name

    def has_work(self) -> bool:
        """True if a scan is to be made, or the lidar's frame has subscribers."""
        return self._has_to_scan() or self._frame.has_subscribers

    def prepare_step(self, timekeeper: Timekeeper) -> None:
        """Announces the scan: the lidars that are due scan together."""
        if self._has_to_scan():
            self._lidar.expect_scan()

    def before_physics_step(self, timekeeper: Timekeeper) -> None:
        self._frame.publish(timekeeper.nanoseconds)
        if self._has_to_scan():
            self.publish_now(timekeeper)

    def publish_now(self, timekeeper: Timekeeper) -> None:
        now = timekeeper.nanoseconds
        ranges, intensities = self._scan(now)
        if self._config.no_return != math.inf:
            ranges = np.where(ranges == np.inf, np.float32(self._config.no_return), ranges)
        self._publisher.write(self._writer, now, ranges, intensities)

    def _has_to_scan(self) -> bool:
        return self._config.always_publish or self._publisher.has_subscribers

    def _scan(self, nanoseconds: int) -> Tuple[Float32Array, Float32Array]:
        ranges, intensities = self._lidar.scan()
        if self._is_noisy:
            ranges = self._add_noise(ranges, nanoseconds)
        return ranges, intensities

    def read(self, timekeeper: Timekeeper) -> Float32Array:
        """The range of each beam [m], shape (n,), as in REP 117.

        It is +inf if the beam hits nothing, and -inf if that is nearer than `range_min`.
        """
        ranges = self._lidar.ranges()
        return self._add_noise(ranges, timekeeper.nanoseconds) if self._is_noisy else ranges

    def read_intensities(self, timekeeper: Timekeeper) -> Float32Array:
        """The intensity of each beam, 0 or 255, shape (n,); (0,) without a layer "reflectance"."""
        return self._scan(timekeeper.nanoseconds)[1]

    def draw(self, canvas: Canvas, timekeeper: Timekeeper) -> None:
        """Draws the area that the beams cross, and a dot where one is returned."""
        laser, ranges = self._config, self.read(timekeeper)
        pose = self._body.pose.compose(laser.origin)
        angles = pose.yaw + self._handedness * self.angles
        reach = np.clip(ranges, laser.range_min, laser.range)
        ends = pose[:2] + reach[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
        if laser.beams > 1:
            canvas.area(np.vstack([pose[:2], ends]), _BEAMS)
        else:
            canvas.path(np.vstack([pose[:2], ends]), _BEAMS)
        canvas.dots(ends[np.isfinite(ranges)], _RETURNS, size=2.5)

    def get_state(self) -> None:
        """Nothing: a scan depends on the present alone, and its noise on the time."""


class ScanWriter(MessageWriter):
    """Makes LaserScans that differ in their times, ranges and intensities alone."""

    def __init__(self, frame_id: str, **fields: float) -> None:
        self._frame_id = frame_id
        self._fields = fields
        self._sequence = 0
        frame = frame_id.encode()
        self._constant = (
            struct.pack("<I", len(frame))
            + frame
            + struct.pack("<7f", *(fields.get(name, 0.0) for name in _CONSTANT_FIELDS))
        )

    def message(self, nanoseconds: int, ranges: Float32Array, intensities: Float32Array) -> Any:
        """A LaserScan with arrays for ranges and intensities."""
        return LaserScan(
            header=header(nanoseconds, self._frame_id),
            ranges=ranges,
            intensities=intensities,
            **self._fields,
        )

    def data(self, nanoseconds: int, ranges: Float32Array, intensities: Float32Array) -> bytes:
        """The same as bytes, field by field as LaserScan has them."""
        self._sequence += 1
        return b"".join(
            (
                struct.pack("<3I", self._sequence, *stamp_of(nanoseconds)),
                self._constant,
                struct.pack("<I", len(ranges)),
                ranges.astype("<f4", copy=False).tobytes(),
                struct.pack("<I", len(intensities)),
                intensities.astype("<f4", copy=False).tobytes(),
            )
        )


@lru_cache(maxsize=16)
def _fan(angle_min: float, increment: float, count: int) -> BeamFan:
    """A fan, shared by equal lidars, so that its tables stay in the processor's cache."""
    return BeamFan(angle_min, increment, count)
