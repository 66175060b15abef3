"""BoolSensor: whether something touches a body."""

import math
from typing import Set

from std_msgs.msg import Bool

from flatland_server import Contact, ModelPlugin, Timekeeper, UpdateTimer, YamlReader


class BoolSensor(ModelPlugin):
    """Publishes std_msgs/Bool: whether something touches the body, or has since the last message.

    A touch between two messages, however short, is reported by the next one. The body may be solid
    or a sensor. Only solid footprints of other models, and walls, count as touching it.
    """

    def on_initialize(self, config: YamlReader) -> None:
        """Reads the documented keys and opens the topic."""
        topic = config.get_topic("topic", "bool_sensor")
        self._body = self.get_body(config, default=self.model.base.name)
        self.update_timer = UpdateTimer(config.get_rate("update_rate", math.inf))
        config.finish()
        self._publisher = self.node.advertise(topic, Bool)
        self._touching: Set[Contact] = set()
        self._is_unreported = False

    def begin_contact(self, contact: Contact) -> None:
        """Records a touch."""
        sides = self.filter_contact(contact)
        if sides is None or sides.entity is self.model or sides.other_fixture.sensor:
            return
        if sides.this_fixture.body == self._body.physics_body:
            self._touching.add(contact)
            self._is_unreported = True

    def end_contact(self, contact: Contact) -> None:
        """Records its end."""
        self._touching.discard(contact)

    def after_physics_step(self, timekeeper: Timekeeper) -> None:
        """Publishes, and forgets touches that have ended."""
        if self._publisher.has_subscribers:
            self._publisher.publish(Bool(self._is_unreported or bool(self._touching)))
        self._is_unreported = False
