"""Plugins that break the contract in one way each, and the messages of the checks."""

import logging
import weakref
from typing import Any, Callable, ClassVar, Dict, Iterator, List, Type

import numpy as np
from geometry_msgs.msg import PointStamped, Vector3
from plugin_testing.beacon import Beacon, PointWriter
from std_msgs.msg import Bool

from flatland_server import Canvas, ModelPlugin, Pose, Timekeeper, Transform, YamlReader
from flatland_server.testing import behaviour_checks, configuration_checks, name_checks
from flatland_server.testing.checked_plugin import CheckedPlugin

REMEMBERED: List[Any] = []


class Breaks(ModelPlugin):
    def on_initialize(self, config: YamlReader) -> None:
        pass

    def before_physics_step(self, timekeeper: Timekeeper) -> None:
        raise ValueError("no luck")


def broken(name: str, **methods: Callable[..., Any]) -> Type[Beacon]:
    """A beacon with other methods."""
    return type(name, (Beacon,), methods)


ReadsMore = broken("ReadsMore", read_more=lambda self, config: config.get_string("secret", ""))


IgnoresUnknownKeys = broken(
    "IgnoresUnknownKeys",
    read_limits=lambda self, config: config.get_section("limits"),  # without finish()
)


class CrashesWithoutKey(Beacon):
    def read_color(self, section: YamlReader) -> float:
        if not section.has("red"):
            raise section.error("no red")
        return section.get_float("red")


class AcceptsNaN(Beacon):
    def read_limits(self, config: YamlReader) -> None:
        limits = config.get_section("limits")
        self.low, self.high = float(limits.get_string("low", "1")), limits.get_float("high", 1.0)


class AcceptsAnyBody(Beacon):
    def read_body(self, config: YamlReader) -> Any:
        return self.model.bodies.get(config.get_string("body"), self.model.base)


class AcceptsRateOfZero(Beacon):
    def read_rate(self, config: YamlReader) -> float:
        return config.get_float("update_rate", 1.0, minimum=0.0, allow_infinity=True) or 1.0


class PublishesWithoutSubscribers(Beacon):
    def shine(self, now: int) -> None:
        self.publisher.publish(PointWriter(self.frame).message(now, 1.0))


class MakesMessagesWithoutSubscribers(Beacon):
    def shine(self, now: int) -> None:
        message = PointWriter(self.frame).message(now, 1.0)
        if self.publisher.has_subscribers:
            self.publisher.publish(message)


class SendsTransformsWithoutSubscribers(Beacon):
    def shine(self, now: int) -> None:
        self.node.send_transform(Transform(now, self.body.name, self.frame, Pose()))


class DependsOnSubscribers(Beacon):
    def shine(self, now: int) -> None:
        if self.publisher.has_subscribers:
            self.publisher.write(self.writer, now, float(self.rng.normal()))


class NeverNoticesSubscribers(Beacon):
    is_noticed = True

    def shine(self, now: int) -> None:
        self.is_noticed = self.is_noticed and self.publisher.has_subscribers
        if self.is_noticed:
            super().shine(now)


NamespacesTopicTwice = broken(
    "NamespacesTopicTwice",
    own_topic=lambda self, topic: "/".join(filter(None, (self.model.namespace, topic.strip("/")))),
)


ForgetsNamespaceOfFrame = broken("ForgetsNamespaceOfFrame", own_frame=lambda self, frame: frame)


HasFixedFrame = broken("HasFixedFrame", own_frame=lambda self, _: self.name_space_tf("lamp"))


class IgnoresItsRate(Beacon):
    def read_rate(self, config: YamlReader) -> float:
        super().read_rate(config)
        return 100.0


StampsWrongly = broken("StampsWrongly", shine=lambda self, now: Beacon.shine(self, now + 1))


class IsNotRepeatable(Beacon):
    def shine(self, now: int) -> None:
        if self.publisher.has_subscribers:
            self.publisher.write(self.writer, now, float(np.random.default_rng().normal()))


class ForgetsItsCount(Beacon):
    count = 0

    def shine(self, now: int) -> None:
        self.count += 1
        if self.publisher.has_subscribers:
            self.publisher.write(self.writer, now, self.count)


class KnowsOfTheLifeBefore(Beacon):
    transports: ClassVar[Any] = weakref.WeakSet()

    def read_more(self, config: YamlReader) -> None:
        self.is_reset = self.node._transport in self.transports
        self.transports.add(self.node._transport)

    def shine(self, now: int) -> None:
        if self.publisher.has_subscribers:
            self.publisher.write(self.writer, now, float(self.is_reset))

    def get_state(self) -> Any:
        return self.is_reset

    def set_state(self, state: Any) -> None:
        self.is_reset = state


class MovesAtRandom(Beacon):
    def on_switch(self, message: Vector3) -> None:
        self.model.move(Pose(np.random.default_rng().normal(), 0.0, 0.0))


class WritesOtherBytes(Beacon):
    class writer_type(PointWriter):
        def data(self, nanoseconds: int, x: float) -> bytes:
            return super().data(nanoseconds, x + 1.0)


class FailsOnNaN(Beacon):
    def on_switch(self, message: Vector3) -> None:
        self.is_on = int(message.x) > 0


class KeepsAPublisher(Beacon):
    def read_more(self, config: YamlReader) -> None:
        self.node._transport.advertise("/left", Bool, latch=False, queue_size=1)


class KeepsASubscription(Beacon):
    def read_more(self, config: YamlReader) -> None:
        self.node._transport.subscribe("/left", Bool, lambda _: None)


IsRemembered = broken("IsRemembered", read_more=lambda self, _: REMEMBERED.append(self))


class KeepsABody(Beacon):
    def read_more(self, config: YamlReader) -> None:
        self.model.physics.add_body("static", (0.0, 0.0, 0.0))


class Warns(Beacon):
    def on_shutdown(self) -> None:
        logging.getLogger(__name__).warning("the lamp is broken")


class GoesOnSending(Beacon):
    def on_shutdown(self) -> None:
        transport, process = self.node._transport, self.node._transport.process
        publisher, frame = self.publisher, self.frame

        def process_and_send(timeout: float = 0.0) -> None:
            process(timeout)
            publisher.publish(PointStamped())
            transport.send_transform(Transform(0, "base", frame, Pose()))

        transport.process = process_and_send


GoesOnPublishing = type("GoesOnPublishing", (GoesOnSending,), {})


class MovesWhenDrawn(Beacon):
    def draw(self, canvas: Canvas, timekeeper: Timekeeper) -> None:
        self.body.physics_body.pose = (1.0, 0.0, 0.0)


class FailsToDraw(Beacon):
    def draw(self, canvas: Canvas, timekeeper: Timekeeper) -> None:
        canvas.dots([(0.0, 0.0)], (1.0, 0.0, 0.0, 1.0), size=1 / 0)


class ChangesItsTopic(Beacon):
    def own_topic(self, topic: str) -> str:
        return topic if self.body.physics_body.id < 2**33 else "another"  # its slot is used again


ReadsItsChance = broken("ReadsItsChance", read=lambda self, timekeeper: self.rng.random())


class CountsReadings(Beacon):
    def read(self, timekeeper):
        self.low += 1e-3
        return 0.0

    def before_physics_step(self, timekeeper):
        self.model.base.physics_body.velocity = (self.low, 0.0, 0.0)
        super().before_physics_step(timekeeper)


class ReadsItsMessage(Beacon):
    published = 0

    def before_physics_step(self, timekeeper):
        super().before_physics_step(timekeeper)
        self.published += self.publisher.has_subscribers

    def read(self, timekeeper):
        return self.published


class BrokenTwice(ReadsMore, Warns):
    """In the first check of all, and in the last."""


BROKEN: Dict[Callable[[CheckedPlugin], Iterator[str]], Dict[Type[Beacon], str]] = {
    configuration_checks.check_keys: {
        ReadsMore: 'the plugin reads the key "secret", which the entry does not show',
    },
    configuration_checks.check_unknown_keys: {
        IgnoresUnknownKeys: 'expected a refusal of "olw" in line',
    },
    configuration_checks.check_missing_keys: {
        CrashesWithoutKey: 'without "colors.red": the required key "red" is missing, found',
    },
    configuration_checks.check_wrong_values: {
        AcceptsNaN: 'expected a refusal of "limits.low: nan" that names the key and line',
        AcceptsAnyBody: 'expected a refusal of "body: abse" that names the key and line',
        AcceptsRateOfZero: 'expected a refusal of "update_rate: 0" that names the key and line',
    },
    behaviour_checks.check_without_subscribers: {
        PublishesWithoutSubscribers: "expected no message, found one published to /point",
        MakesMessagesWithoutSubscribers: "expected no message made for /point, found 100",
        SendsTransformsWithoutSubscribers: 'expected no transform, found one of the frame "lamp"',
        DependsOnSubscribers: "expected the same messages, however late a topic gets its",
        NeverNoticesSubscribers: "expected a message on /point after it has got a subscriber",
    },
    name_checks.check_names: {
        NamespacesTopicTwice: "expected published /robot1/point, found /robot1/robot1/point",
        ForgetsNamespaceOfFrame: "expected message frames /robot1/point robot1_lamp, found",
        HasFixedFrame: "renamed: expected transforms base renamed_lamp, found base lamp",
    },
    behaviour_checks.check_rates: {
        IgnoresItsRate: "update_rate: inf: expected /point in steps 1, 2 ..., found [1, 3, 5",
        StampsWrongly: "expected /point to be stamped with the time, 0 ns, found 1 ns",
    },
    behaviour_checks.check_messages: {
        IsNotRepeatable: "expected the same messages from equal seeds, found a difference in",
        MovesAtRandom: "expected the same poses and walls from equal seeds, found a difference",
        WritesOtherBytes: "expected the MessageWriter of /point to make bytes that equal its",
    },
    behaviour_checks.check_states: {
        ForgetsItsCount: "expected the same messages after its state was saved and loaded",
        KnowsOfTheLifeBefore: "expected the same messages after a reset, found a difference in",
    },
    behaviour_checks.check_drawing: {
        MovesWhenDrawn: "expected the same run with pictures as without, found a difference",
        FailsToDraw: "expected to draw itself, found draw: ZeroDivisionError",
    },
    behaviour_checks.check_readings: {
        ReadsItsChance: "expected equal readings at one time, found 0.",
        CountsReadings: "expected the same poses and walls after readings, found a difference",
        ReadsItsMessage: "expected the same reading without subscribers, found 0",
    },
    behaviour_checks.check_bad_messages: {
        FailsOnNaN: "expected a message full of nan to be ignored, found its callback of switch",
    },
    behaviour_checks.check_end: {
        KeepsAPublisher: "after its end: expected no publisher, found one of /left",
        KeepsASubscription: "after its end: expected no subscription, found one of /left",
        IsRemembered: "after its end: expected no reference to the plugin, found one",
        KeepsABody: "expected no body or joint of a deleted robot, found one that is left",
        Warns: "expected no warning while the robot is deleted and spawned, found",
        ChangesItsTopic: "expected the topics of the first robot after it was spawned again",
        GoesOnPublishing: "after its end: expected no message, found one on /point",
        GoesOnSending: 'after its end: expected no transform, found one of "lamp"',
    },
}
"""For each check of the contract, plugins that do not pass it, and its messages."""
