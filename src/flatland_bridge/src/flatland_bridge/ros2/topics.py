"""A topic in ROS 2: a publisher of what a graph publishes, or a subscription for it."""

import logging
import time
from contextlib import suppress
from functools import partial
from typing import Callable, NamedTuple, Optional

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.qos_overriding_options import QoSOverridingOptions

from flatland_bridge.budget import Budget, Budgets
from flatland_bridge.graph import BridgeError, Graph
from flatland_bridge.outbox import Stream
from flatland_bridge.ros2.types import Types
from flatland_bridge.sample import Sample
from flatland_server.exceptions import shortened
from flatland_server.messages import deserialized, get

logger = logging.getLogger(__name__)

_CDR = "cdr"
"""The name of the encoding of samples."""


class Key(NamedTuple):
    """A topic as it is opened.

    Attributes:
        topic: its absolute name in the graph.
        kind: the name of its type in ROS 2.
        is_latched: whether it sends its last message to new subscribers.
    """

    topic: str
    kind: str
    is_latched: bool = False

    @property
    def qos(self) -> QoSProfile:
        """The quality of service, unless parameters `qos_overrides` say otherwise.

        All are reliable, which serves subscribers that ask for best effort, too. A slow one does
        not hold up the publisher: it loses the oldest messages.
        """
        if self.is_latched:
            return QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        if self.kind.startswith("sensor_msgs/") and self.kind != "sensor_msgs/JointState":
            return QoSProfile(depth=5)
        return QoSProfile(depth=100 if self.topic.endswith("/tf") else 10)

    @property
    def name(self) -> str:
        """The name in ROS 2, in the node's namespace but for those that are the same for all."""
        is_global = self.topic in ("/tf", "/tf_static", "/clock")
        return self.topic if is_global else self.topic[1:]

    def overriding(self, node: Node) -> Optional[QoSOverridingOptions]:
        """Lets parameters change the quality of service, if there are any for it."""
        name = node.resolve_topic_name(self.name)
        has_any = node.get_parameters_by_prefix(f"qos_overrides.{name}")
        return QoSOverridingOptions.with_default_policies() if has_any else None


class Output:
    """Publishes a topic of a graph, to which it subscribes while there are subscribers.

    Args:
        node: node of ROS 2 that publishes the topic.
        graph: graph with the topic.
        key: name and type of the topic.
        types: makes rclpy's class, and converts.
        wake: called when there is something to send.
    """

    def __init__(
        self, node: Node, graph: Graph, key: Key, types: Types, wake: Callable[[], None]
    ) -> None:
        self._node = node
        self._graph = graph
        self._key = key
        cls, self._type = types.topic(get(key.kind))
        self._publisher = node.create_publisher(
            cls, key.name, key.qos, qos_overriding_options=key.overriding(node)
        )
        self._budget = Budgets().open()
        length = 1 if key.is_latched else 0
        self._stream = Stream(lambda sample: (), wake, self._budget, length=length)
        self._end: Optional[Callable[[], None]] = None
        self._clock, self._has_ticked = b"", False  # the last message of /clock

    def follow(self) -> bool:
        """Looks for subscribers; False if the publisher has to be replaced.

        A latched one keeps the last message for new subscribers, which would be an old one when
        they come after others have gone.
        """
        has_subscribers = self._publisher.get_subscription_count() > 0
        if self._clock and not self._has_ticked:  # in a pause, for new subscribers
            self._publisher.publish(self._clock)
        self._has_ticked = False
        if has_subscribers and self._end is None:
            with suppress(BridgeError):  # the simulation cannot keep up: later
                self._end = self._graph.subscribe(
                    self._key.topic, self._stream.receive, self._budget
                )
        elif self._end is not None and not has_subscribers:
            self._unsubscribe()
            return not self._key.is_latched
        return True

    def send(self) -> None:
        """Sends what waits."""
        while True:
            sample = self._stream.take(time.monotonic())
            if sample is None:
                return
            data = sample.encoded(_CDR, self._encode)
            self._publisher.publish(data)
            if self._key.topic == "/clock":
                self._clock, self._has_ticked = data, True

    def _encode(self, sample: Sample) -> bytes:
        return self._type.to_cdr(sample.data)

    def _unsubscribe(self) -> None:
        if self._end is not None:
            self._end()
            self._end = None

    def close(self) -> None:
        """Ends it."""
        self._unsubscribe()
        self._stream.close()
        self._node.destroy_publisher(self._publisher)


class Input:
    """Receives messages for a graph's topic.

    Args:
        node: node of ROS 2 that subscribes to the topic.
        graph: graph with the topic.
        key: the topic, with the type that it has in ROS 2.
        types: makes rclpy's class, and converts.
        budget: counts what waits for the simulation.
    """

    def __init__(self, node: Node, graph: Graph, key: Key, types: Types, budget: Budget) -> None:
        self._node = node
        self._name = key.topic
        self._kind = get(key.kind)
        self._is_stamped = graph.topics.subscribed[key.topic] != key.kind
        cls, self._type = types.topic(self._kind)
        self._publish = partial(graph.publish, key.topic, client=budget)
        self._has_warned = False
        self._subscription = node.create_subscription(
            cls,
            key.name,
            self._receive,
            key.qos,
            raw=True,
            qos_overriding_options=key.overriding(node),
        )

    def _receive(self, data: bytes) -> None:
        try:
            message = deserialized(self._kind, self._type.from_cdr(data), "strict")
            self._publish(message.twist if self._is_stamped else message)
        except BridgeError as error:
            self._warn(str(error))
        except Exception as error:  # of any kind, from any depth of rosbags
            self._warn(f"expected a {self._kind._type}: {shortened(str(error))}")

    def _warn(self, text: str) -> None:
        if not self._has_warned:
            logger.warning("%s: %s", self._name, text)
            self._has_warned = True

    def close(self) -> None:
        """Ends it."""
        self._node.destroy_subscription(self._subscription)
