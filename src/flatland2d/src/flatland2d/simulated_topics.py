"""The topics of a simulation: subscribing, reading and publishing messages."""

from typing import Any, Dict, Iterable

from flatland_server.arguments import shown
from flatland_server.exceptions import TopicError, UsageError, unknown
from flatland_server.geometry import Transform
from flatland_server.messages import transform_of
from flatland_server.simulation import RunWithHistory, World
from flatland_server.timekeeper import Timekeeper
from flatland_server.transport import LocalTransport, type_name

TF = "/tf"


class SimulatedTopics(RunWithHistory):
    """The part of a `Simulation` that handles topics.

    Args: those of `Run`; the world's transport must be a `LocalTransport`.
    """

    transport: LocalTransport

    def __init__(self, world: World, timekeeper: Timekeeper, *, raise_failures: bool) -> None:
        super().__init__(world, timekeeper, raise_failures=raise_failures)
        self._subscribed: Dict[str, None] = {}

    @property
    def topics(self) -> Dict[str, str]:
        """The types of all topics that plugins publish or subscribe to, by their names."""
        return self.world.topics

    def subscribe(self, *topics: str) -> None:
        """Makes plugins compute topics from now on, for `last`; as with ROS, others cost nothing.

        Args:
            topics: their names; "/tf" for `transforms`. They need not exist yet.

        Raises:
            UsageError: a name is no string, or the simulation is closed.
        """
        self.require_open()
        new = {_absolute(topic): None for topic in topics}
        if not new.keys() <= self._subscribed.keys():
            self._subscribed.update(new)
            self.transport.set_subscribed_topics(frozenset(self._subscribed))

    def last(self, topic: str) -> Any:
        """The newest message of a topic; None if there is none yet.

        The first call for a topic subscribes to it, and makes its plugin publish a measurement at
        once. Further messages come as with ROS, at the rate of the plugin: scans, fixes and
        odometry are published at the beginning of a step, so that after it they are a step older
        than `poses`; Bumper, BoolSensor and Imu publish at the end of a step. A sensor's `read`
        always measures at the present time.

        Args:
            topic: name of the topic, with or without a leading "/".

        Raises:
            TopicError: no plugin publishes to this topic.
            UsageError: the simulation is closed.
        """
        self.require_open()
        name = _absolute(topic)
        if name not in self._subscribed:
            self._require_known(name, self.transport.topics, "publishes to")
            self.subscribe(name)
            if self.world.is_between_steps and self.transport.last_latched(name) is None:
                with self.transport.without_delivery():
                    self.world.contents.plugins.publish_now(name, self.timekeeper)
                self._raise_failures()
        return self.transport.last(name)

    @property
    def transforms(self) -> Dict[str, Transform]:
        """The newest transform of each frame, by the name of the frame; needs `subscribe("/tf")`.

        Raises:
            TopicError: "/tf" was not subscribed to, so that no transforms are computed.
        """
        if TF not in self._subscribed:
            raise TopicError('expected subscribe("/tf") before the steps', TF)
        static = self.transport.static_transforms.transforms
        return {
            **{frame: transform_of(message) for frame, message in static.items()},
            **self.transport.transforms,
        }

    def publish(self, topic: str, message: Any) -> None:
        """Publishes a message; its subscribers get it at once, and act on it in the next step.

        Args:
            topic: name of the topic, with or without a leading "/".
            message: of the topic's type; see `messages.get`.

        Raises:
            TopicError: no plugin subscribes to this topic, or with messages of another type.
            UsageError: the simulation is closed.
        """
        self.require_open()
        name = _absolute(topic)
        if name not in self.transport.subscribed:
            self._require_known(name, self.transport.subscribed, "subscribes to")
        expected, found = self.topics.get(name), type_name(type(message))
        if expected is not None and expected != found:
            raise TopicError(f'the topic "{name}" expects {expected}, found {found}', topic)
        self.transport.send(name, message)
        if self.world.is_between_steps:
            self.transport.process()
            self._raise_failures()

    def _require_known(self, topic: str, known: Iterable[str], verb: str) -> None:
        """Raises a TopicError unless a topic is among those that are known."""
        names = sorted(known)
        if topic not in names:
            raise TopicError(unknown(f"no plugin {verb}", topic, names), topic)


def _absolute(topic: str) -> str:
    if not isinstance(topic, str):
        raise UsageError(f"expected the name of a topic, found {shown(topic)}")
    return topic if topic.startswith("/") else f"/{topic}"
