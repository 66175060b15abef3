"""Beacon: a plugin that keeps the contract; `broken_beacons` has others, which do not."""

from io import BytesIO
from typing import Any, Type

import numpy as np
from geometry_msgs.msg import PointStamped, Vector3

from flatland_server import (
    MessageWriter,
    ModelPlugin,
    Pose,
    Timekeeper,
    Transform,
    UpdateTimer,
    YamlReader,
    header,
)

ENTRY = {
    "type": "Beacon",
    "name": "beacon",
    "body": "base",
    "topic": "point",
    "switch_topic": "switch",
    "frame": "lamp",
    "update_rate": "inf",
    "limits": {"low": 1.0, "high": 2.0},
    "colors": [{"red": 0.5}],
}


class PointWriter(MessageWriter):
    def __init__(self, frame: str) -> None:
        self._frame = frame

    def message(self, nanoseconds: int, x: float) -> PointStamped:
        message = PointStamped(header=header(nanoseconds, self._frame))
        message.point.x = x
        return message

    def data(self, nanoseconds: int, x: float) -> bytes:
        buffer = BytesIO()
        self.message(nanoseconds, x).serialize(buffer)
        return buffer.getvalue()


class Beacon(ModelPlugin):
    writer_type: Type[MessageWriter] = PointWriter

    def on_initialize(self, config: YamlReader) -> None:
        self.body = self.read_body(config)
        topic = config.get_string("topic", "point")
        switch_topic = config.get_string("switch_topic", "switch")
        self.frame = self.own_frame(config.get_string("frame", "lamp"))
        rate = self.read_rate(config)
        self.read_limits(config)
        config.get_sections("colors", self.read_color)
        self.read_more(config)
        config.finish()
        self.is_on = True
        self.update_timer = UpdateTimer(rate)
        self.publisher = self.node.advertise(self.own_topic(topic), PointStamped)
        self.node.subscribe(switch_topic, Vector3, self.on_switch)
        self.writer = self.writer_type(self.frame)

    def read_body(self, config: YamlReader) -> Any:
        return self.get_body(config)

    def read_rate(self, config: YamlReader) -> float:
        return config.get_rate("update_rate", 10.0)

    def read_limits(self, config: YamlReader) -> None:
        limits = config.get_section("limits")
        self.low, self.high = limits.get_float("low", 1.0), limits.get_float("high", 2.0)
        limits.finish()

    def read_color(self, section: YamlReader) -> float:
        red = section.get_float("red", 1.0)
        section.finish()
        return red

    def read_more(self, config: YamlReader) -> None:
        pass

    def own_frame(self, frame: str) -> str:
        return self.name_space_tf(frame)

    def own_topic(self, topic: str) -> str:
        return topic

    def on_switch(self, message: Vector3) -> None:
        self.is_on = message.x < 1.0

    def before_physics_step(self, timekeeper: Timekeeper) -> None:
        self.shine(timekeeper.nanoseconds)

    def shine(self, now: int) -> None:
        if self.publisher.has_subscribers:
            x = np.random.default_rng([7, now]).normal()
            self.publisher.write(self.writer, now, float(x))
        if self.node.transforms_have_subscribers:
            parent = self.name_space_tf(self.body.name)
            self.node.send_transform(Transform(now, parent, self.frame, Pose()))
