"""A topic over DDS: a writer of what a graph publishes, or a reader of what it subscribes to."""

import logging
import time
from contextlib import suppress
from typing import Any, Callable, NamedTuple, Optional, Tuple

from cyclonedds.core import DDSException, DDSStatus
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy, Qos
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic

from flatland_bridge.budget import Budgets
from flatland_bridge.graph import BridgeError, Graph
from flatland_bridge.outbox import Stream
from flatland_bridge.sample import Sample
from flatland_server.exceptions import shortened
from flatland_server.messages.message_types import deserialized

logger = logging.getLogger(__name__)

_CDR = "cdr"
"""The name of the encoding of samples."""
_POLICIES = {2: "durability", 11: "reliability"}
"""Why a subscriber does not match, by numbers of the standard."""


class Profile(NamedTuple):
    """The quality of service of a topic."""

    depth: int = 10
    is_reliable: bool = True
    is_latched: bool = False

    def qos(self, message_class: Any) -> Qos:
        """The same for a reader or writer."""
        reliability = Policy.Reliability
        # A writer does not wait for readers: the oldest message is lost.
        reliable = reliability.Reliable(max_blocking_time=0)
        durability = Policy.Durability
        return Qos(
            reliable if self.is_reliable else reliability.BestEffort,
            durability.TransientLocal if self.is_latched else durability.Volatile,
            Policy.History.KeepLast(self.depth),
            Policy.DataRepresentation(use_cdrv0_representation=True),
            Policy.Userdata(f"typehash={message_class.type_hash};".encode()),
        )


def default_profile(topic: str, kind: str, is_latched: bool) -> Profile:
    """The profile that nodes of ROS 2 publish a topic with, if they do not say otherwise.

    Args:
        topic: its absolute name.
        kind: the type of its messages.
        is_latched: whether new subscribers get the last message.
    """
    if is_latched:
        return Profile(depth=1, is_latched=True)
    if kind.startswith("sensor_msgs/") and kind != "sensor_msgs/JointState":
        return Profile(depth=5, is_reliable=False)
    return Profile(depth=100 if topic.endswith("/tf") else 10)


def open_writer(
    participant: DomainParticipant, name: str, message_class: Any, profile: Profile
) -> Any:
    """A writer.

    Args:
        participant: of it.
        name: of the topic, as DDS has it.
        message_class: the subclass of `CdrMessage` for its messages.
        profile: its quality of service.
    """
    topic = Topic(participant, name, message_class)
    return DataWriter(participant, topic, profile.qos(message_class))


class Output:
    """Publishes a topic of a graph, to which it subscribes while DDS has subscribers.

    Args:
        writer: of the topic.
        graph: has the topic.
        topic: its absolute name.
        profile: the writer's.
        wake: called when there is something to send.
    """

    def __init__(
        self, writer: Any, graph: Graph, topic: str, profile: Profile, wake: Callable[[], None]
    ) -> None:
        self.writer = writer
        self._graph = graph
        self._topic = topic
        self._profile = profile
        length = 1 if profile.is_latched else 0
        self._budget = Budgets().open()
        self._stream = Stream(lambda sample: (), wake, self._budget, length=length)
        self._end: Optional[Callable[[], None]] = None
        self._mismatches = 0

    def follow(self) -> bool:
        """Looks for subscribers; False if the writer has to be replaced.

        A writer keeps the last message for new subscribers, which would be an old one when they
        come after others have gone.
        """
        has_readers = self.writer.get_publication_matched_status().current_count > 0
        if has_readers and self._end is None:
            with suppress(BridgeError):  # the simulation cannot keep up: later
                self._end = self._graph.subscribe(self._topic, self._stream.receive, self._budget)
        elif self._end is not None and not has_readers:
            self.close()
            return not self._profile.is_latched
        status = self.writer.get_offered_incompatible_qos_status()
        if status.total_count > self._mismatches:
            policy = _POLICIES.get(status.last_policy_id, f"policy {status.last_policy_id}")
            logger.warning(
                "a subscriber to %s gets no messages: it asks for another %s than is offered (%s)",
                *(self._topic, policy, ", ".join(self._offers())),
            )
        self._mismatches = status.total_count
        return True

    def _offers(self) -> Tuple[str, str]:
        return (
            "reliable" if self._profile.is_reliable else "best effort",
            "transient local" if self._profile.is_latched else "volatile",
        )

    def send(self) -> None:
        """Sends what waits."""
        data_type = self.writer.data_type

        def encode(sample: Sample) -> bytes:
            return bytes(data_type.to_cdr(sample.data))

        while True:
            sample = self._stream.take(time.monotonic())
            if sample is None:
                return
            try:
                self.writer.write(data_type(sample.encoded(_CDR, encode)))
            except DDSException as error:  # lost: what waits for slow subscribers is too large
                logger.debug("%s: %s", self._topic, error)

    def close(self) -> None:
        """Ends the subscription."""
        if self._end is not None:
            self._end()
            self._end = None


class Input:
    """Receives messages for a graph's topic.

    Args:
        participant: of the reader.
        name: of the topic, as DDS has it.
        message_class: the subclass of `CdrMessage` for its messages.
        kind: their class in the graph.
        publish: publishes a message to the graph's topic.
    """

    def __init__(
        self,
        participant: DomainParticipant,
        name: str,
        message_class: Any,
        kind: Any,
        publish: Callable[[Any], None],
    ) -> None:
        self._name = name
        self._kind = kind
        self._publish = publish
        self._has_warned = False
        profile = Profile()
        self._depth = profile.depth
        topic = Topic(participant, name, message_class)
        self.reader: Any = DataReader(participant, topic, profile.qos(message_class))
        self.reader.set_status_mask(DDSStatus.DataAvailable)

    def receive(self) -> None:
        """Publishes what has come; warns once if it cannot be read."""
        for each in self.reader.take(self._depth):
            if not each.sample_info.valid_data:  # a writer has gone
                continue
            try:
                data = self.reader.topic.data_type.from_cdr(each.data)
                self._publish(deserialized(self._kind, data, "strict"))
            except BridgeError as error:
                self._warn(str(error))
            except Exception as error:  # of any kind, from any depth of rosbags
                self._warn(f"expected a {self._kind._type}: {shortened(str(error))}")

    def _warn(self, text: str) -> None:
        if not self._has_warned:
            logger.warning("%s: %s", self._name, text)
            self._has_warned = True
