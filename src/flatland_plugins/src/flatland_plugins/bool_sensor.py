"""BoolSensor: whether something touches a body."""

import math
from typing import Set

from std_msgs.msg import Bool

from flatland_server import Contact, ModelPlugin, Timekeeper, UpdateTimer, YamlReader


class BoolSensor(ModelPlugin):
    """Publishes std_msgs/Bool: whether something touches the body, or has since the last message.

    A touch that no message has told of is remembered until the next one, however short it was. The
    body may be solid or a sensor. What touches it is solid, and not of the same model.
    """

    def on_initialize(self, config: YamlReader) -> None:
        """Reads the documented keys and opens the topic."""
        topic = config.get_string("topic", "bool_sensor")
        self._body = self.get_body(config, default=self.model.base.name)
        self.update_timer = UpdateTimer(config.get_rate("update_rate", math.inf))
        config.finish()
        self._publisher = self.node.advertise(topic, Bool)
        self._touching: Set[Contact] = set()
        self._is_untold = False

    def begin_contact(self, contact: Contact) -> None:
        """Notes a touch."""
        sides = self.filter_contact(contact)
        if sides is None or sides.entity is self.model or sides.other_fixture.sensor:
            return
        if sides.this_fixture.body == self._body.physics_body:
            self._touching.add(contact)
            self._is_untold = True

    def end_contact(self, contact: Contact) -> None:
        """Notes its end."""
        self._touching.discard(contact)

    def after_physics_step(self, timekeeper: Timekeeper) -> None:
        """Publishes, and forgets the touches that are over."""
        if self._publisher.has_subscribers:
            self._publisher.publish(Bool(self._is_untold or bool(self._touching)))
        self._is_untold = False
