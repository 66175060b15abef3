"""BoolSensor: whether something touches a body."""

import math
from typing import Any, Dict, Optional, Set, Tuple

from flatland_server import (
    BatchRole,
    Contact,
    Fixture,
    ModelPlugin,
    Timekeeper,
    UpdateTimer,
    YamlReader,
    messages,
)

Bool = messages.get("std_msgs/Bool")


class BoolSensor(ModelPlugin):
    """Publishes std_msgs/Bool: whether something touches the body, or has since the last message.

    A touch between two messages, however short, is reported by the next one. The body may be solid
    or a sensor. Only solid footprints of other models, and walls, count as touching it.
    """

    batch_role = BatchRole()

    def on_initialize(self, config: YamlReader) -> None:
        topic = config.get_topic("topic", "bool_sensor")
        self._body = self.get_body(config, default=self.model.base.name)
        self.update_timer = UpdateTimer(config.get_rate("update_rate", math.inf))
        config.finish()
        self._publisher = self.node.advertise(topic, "std_msgs/Bool")
        self._touching: Set[Tuple[Fixture, Fixture]] = set()
        self._is_unreported = False
        self._value, self._value_time = False, -1  # of the last message
        # Without a rate, it is not called while its topic has no subscriber: times say what a
        # message would have been.
        self._has_rate = self.update_timer.period > 0.0
        self._timekeeper: Optional[Timekeeper] = None  # from the first step on
        self._begin_time = self._end_time = -1  # of the last begin, and of the last end [ns]

    def has_work(self) -> bool:
        """True in the first step, with a rate, or if the topic has a subscriber."""
        return self._timekeeper is None or self._has_rate or self._publisher.has_subscribers

    def before_physics_step(self, timekeeper: Timekeeper) -> None:
        """Keeps the clock, which contact hooks read."""
        if self._timekeeper is None:
            self._timekeeper = timekeeper
            self.update_timer = self.update_timer  # `has_work` is called again

    def begin_contact(self, contact: Contact) -> None:
        """Records a touch."""
        sides = self.filter_contact(contact)
        if sides is None or sides.entity is self.model or sides.other_fixture.sensor:
            return
        if sides.this_fixture.body == self._body.physics_body:
            self._touching.add((contact.fixture_a, contact.fixture_b))
            self._is_unreported = True
            self._begin_time = self._now()

    def end_contact(self, contact: Contact) -> None:
        """Records the end of a touch."""
        self._touching.discard((contact.fixture_a, contact.fixture_b))
        self._end_time = self._now()

    def after_physics_step(self, timekeeper: Timekeeper) -> None:
        """Publishes, and forgets touches that have ended."""
        self._value = self._measure(timekeeper)
        self._value_time = timekeeper.nanoseconds
        if self._publisher.has_subscribers:
            self._publisher.publish(Bool(self._value))
        self._is_unreported = False

    def publish_now(self, timekeeper: Timekeeper) -> None:
        self._publisher.publish(Bool(self.read(timekeeper)))

    def read(self, timekeeper: Timekeeper) -> bool:
        """True if something touches the body, or has since the last time that a message was due."""
        if timekeeper.nanoseconds == self._value_time:
            return self._value
        return self._measure(timekeeper)

    def _measure(self, timekeeper: Timekeeper) -> bool:
        """The value of a message at the end of the last step."""
        if self._has_rate:
            return self._is_unreported or bool(self._touching)
        now = timekeeper.nanoseconds
        has_begun = self._begin_time == now - timekeeper.step_nanoseconds
        return has_begun or bool(self._touching) or self._end_time == now  # it ended after the step

    def _now(self) -> int:
        return -1 if self._timekeeper is None else self._timekeeper.nanoseconds

    def get_state(self) -> Dict[str, Any]:
        """The present touches, and whether a touch is still to be reported."""
        describe = self.model.entities.describe
        touching = [[describe(a), describe(b)] for a, b in self._touching]
        value = [self._value, self._value_time]
        if not self._has_rate and self._timekeeper is not None:
            value = [self.read(self._timekeeper), self._timekeeper.nanoseconds]
        return {
            "touching": touching,
            "is_unreported": self._is_unreported and self._has_rate,
            "value": value,
        }

    def set_state(self, state: Dict[str, Any]) -> None:
        find = self.model.entities.fixture
        self._touching = {(find(a), find(b)) for a, b in state["touching"]}
        self._is_unreported = state["is_unreported"]
        self._value, self._value_time = state["value"]
