"""The subscriptions with a message since the last step, for control in lockstep."""

from typing import Any, Dict, List, Optional

_COMMAND = "geometry_msgs/Twist"


class Arrivals:
    """The subscriptions of a transport, and the step before which each got its last message."""

    def __init__(self) -> None:
        self.step = 0
        self._subscriptions: Dict[str, List[Arrival]] = {}
        self.commands: List[Arrival] = []
        """The subscriptions to commands of robots."""

    def open(self, topic: str, message_type: Any = None) -> "Arrival":
        """A new subscription.

        Args:
            topic: absolute name of the topic, such as "/robot1/scan".
            message_type: of its messages; those of `_COMMAND` command a robot.
        """
        arrival = Arrival(self, topic)
        if getattr(message_type, "_type", None) == _COMMAND:
            self.commands.append(arrival)
        self._subscriptions.setdefault(topic, []).append(arrival)
        return arrival

    def close(self, arrival: "Arrival") -> None:
        """Forgets a subscription."""
        self.commands = [each for each in self.commands if each is not arrival]
        left = [each for each in self._subscriptions.get(arrival.topic, []) if each is not arrival]
        if left:
            self._subscriptions[arrival.topic] = left
        else:
            self._subscriptions.pop(arrival.topic, None)

    def note(self, topic: str) -> None:
        """Notes a message for all subscriptions of a topic."""
        for each in self._subscriptions.get(topic, []):
            each.note()

    def is_first(self, arrival: "Arrival") -> bool:
        """True if a subscription is the oldest one of its topic."""
        return self._subscriptions.get(arrival.topic, [None])[0] is arrival

    def next_step(self) -> None:
        """Notes the end of a step: no subscription has got a message since."""
        self.step += 1

    @property
    def topics(self) -> List[str]:
        """The topics with a subscription."""
        return list(self._subscriptions)

    def has_received(self, topic: str) -> Optional[bool]:
        """True if each subscription of a topic has got a message since the last step.

        Returns:
            None if the topic has no subscription.
        """
        subscriptions = self._subscriptions.get(topic)
        if subscriptions is None:
            return None
        return all(each.step == self.step for each in subscriptions)


class Arrival:
    """A subscription, and the step before which it got its last message."""

    def __init__(self, arrivals: Arrivals, topic: str) -> None:
        self.topic = topic
        self.step = -1
        self._arrivals = arrivals

    def note(self) -> None:
        """Notes a message."""
        self.step = self._arrivals.step

    def forget(self) -> None:
        """Forgets the last message."""
        self.step = -1
