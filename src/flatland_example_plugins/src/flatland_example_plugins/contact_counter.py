"""ContactCounter: counts the contacts of a model."""

import logging
from collections import Counter
from typing import Dict

from flatland_server import Contact, ModelPlugin, Timekeeper, UpdateTimer, YamlReader, messages

Int32 = messages.get("std_msgs/Int32")

logger = logging.getLogger(__name__)


class ContactCounter(ModelPlugin):
    """Counts new contacts with each model and layer, and publishes their sum.

    A wall is one contact, a corner of two walls is two.
    """

    def on_initialize(self, config: YamlReader) -> None:
        """Reads the topic and its rate [Hz]."""
        topic = config.get_topic("topic", "contacts")
        self.update_timer = UpdateTimer(config.get_rate("update_rate", 10.0))
        self._publisher = self.node.advertise(topic, "std_msgs/Int32")
        self._counts: Counter[str] = Counter()

    def begin_contact(self, contact: Contact) -> None:
        """Called whenever two fixtures start to touch, regardless of the `update_timer`."""
        sides = self.filter_contact(contact)
        if sides is not None and sides.entity is not self.model:
            self._counts[sides.entity.name] += 1

    def after_physics_step(self, timekeeper: Timekeeper) -> None:
        """Called when the `update_timer` is due."""
        if self._publisher.has_subscribers:
            self.publish_now(timekeeper)

    def read(self, timekeeper: Timekeeper) -> int:
        """The sum so far, as a program reads it."""
        return sum(self._counts.values())

    def publish_now(self, timekeeper: Timekeeper) -> None:
        """Publishes the sum: when it is due, or when a program starts to read the topic."""
        self._publisher.publish(Int32(self.read(timekeeper)))

    def get_state(self) -> Dict[str, int]:
        """The plain data to keep in a saved state."""
        return self._counts

    def set_state(self, state: Dict[str, int]) -> None:
        """Called on a new plugin, after `on_initialize`, when a state is loaded."""
        self._counts = Counter(state)

    def on_shutdown(self) -> None:
        logger.info("%s: contacts by what was touched: %s", self.name, dict(self._counts))
