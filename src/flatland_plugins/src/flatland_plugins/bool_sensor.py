"""BoolSensor: whether something touches a body."""

import math
from typing import Any, Dict, Set, Tuple

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

    def begin_contact(self, contact: Contact) -> None:
        """Records a touch."""
        sides = self.filter_contact(contact)
        if sides is None or sides.entity is self.model or sides.other_fixture.sensor:
            return
        if sides.this_fixture.body == self._body.physics_body:
            self._touching.add((contact.fixture_a, contact.fixture_b))
            self._is_unreported = True

    def end_contact(self, contact: Contact) -> None:
        """Records the end of a touch."""
        self._touching.discard((contact.fixture_a, contact.fixture_b))

    def after_physics_step(self, timekeeper: Timekeeper) -> None:
        """Publishes, and forgets touches that have ended."""
        self._value = self._is_unreported or bool(self._touching)
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
        return self._is_unreported or bool(self._touching)

    def get_state(self) -> Dict[str, Any]:
        """The present touches, and whether a touch is still to be reported."""
        describe = self.model.entities.describe
        touching = [[describe(a), describe(b)] for a, b in self._touching]
        value = [self._value, self._value_time]
        return {"touching": touching, "is_unreported": self._is_unreported, "value": value}

    def set_state(self, state: Dict[str, Any]) -> None:
        find = self.model.entities.fixture
        self._touching = {(find(a), find(b)) for a, b in state["touching"]}
        self._is_unreported = state["is_unreported"]
        self._value, self._value_time = state["value"]
