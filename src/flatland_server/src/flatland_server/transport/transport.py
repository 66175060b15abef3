"""The interface of a transport: topics, transforms and parameters, over ROS or in this process.

`flatland_server.ros.ros_transport` implements it with rospy, and
`flatland_server.transport.local_transport` within this process, without a ROS master. A plugin does
not use a transport itself but its `Node`, and so runs with either of them.
"""

import math
from abc import ABC, abstractmethod
from typing import Any, Callable, Iterable, List, Optional, Sequence, Tuple, Union

from flatland_server._core import BodyMessage, RelativePoses, StepMessage
from flatland_server.geometry import Pose, Transform
from flatland_server.transport.arrivals import Arrivals

Recipient = Union[str, Tuple[str, str]]
"""A topic with subscribers, or a plugin: the name of its model, and its own."""


class MessageWriter(ABC):
    """Makes the messages of one topic.

    Serializing a ROS message object field by field takes tens of microseconds, even if it has only
    a few numbers among constants. So a transport that sends bytes uses `data`, and one that keeps
    objects uses `message`. Both have the same contents.
    """

    @abstractmethod
    def message(self, *values: Any) -> Any:
        """The message as an object.

        Args:
            values: as the writer defines them.
        """

    @abstractmethod
    def data(self, *values: Any) -> bytes:
        """The serialized message. Each call increments the sequence number of the header.

        Args:
            values: the same as for `message`.
        """


class Publisher(ABC):
    """Publishes messages to one topic."""

    @property
    @abstractmethod
    def has_subscribers(self) -> bool:
        """True if the topic has a subscriber. Check it before computing a message."""

    @abstractmethod
    def publish(self, message: Any) -> None:
        """Publishes a message.

        Args:
            message: of the topic's type; it must not be changed afterwards.
        """

    def write(self, writer: MessageWriter, *values: Any) -> None:
        """Publishes the message that a writer makes of values, in this transport's fastest form.

        Does nothing if the topic has no subscriber.

        Args:
            writer: makes a message of values, or its bytes.
            values: arguments of the writer.
        """
        if self.has_subscribers:
            self.publish(writer.message(*values))

    def step_message(self, message: BodyMessage) -> Optional[StepMessage]:
        """A message that the core writes to the present subscribers at each step.

        Args:
            message: the message that the core writes.

        Returns:
            None if the transport cannot do this: `write` has to be called.
        """
        return None

    @abstractmethod
    def close(self) -> None:
        """Unregisters the publisher."""


class Subscription(ABC):
    """Receives the messages of one topic until it is closed."""

    @abstractmethod
    def close(self) -> None:
        """Unsubscribes; the callback is not called any more."""


class Frames:
    """Frames with transforms that are sent together; the parent of each stays the same.

    Args:
        sender: sends the transforms.
        names: the parent and the child of each frame.
    """

    def __init__(self, sender: "TransformSender", names: Sequence[Tuple[str, str]]) -> None:
        self._sender = sender
        self._names = names

    def send(self, nanoseconds: int, poses: Iterable[Tuple[float, float, float]]) -> None:
        """Sends the transforms of one time.

        Args:
            nanoseconds: the simulated time [ns].
            poses: of each frame in its parent: x, y [m] and yaw [rad]. Those of `RelativePoses` are
                read and written by the core, at a fifth of the cost.
        """
        for (parent, child), pose in zip(self._names, poses):
            self._sender.send_transform(Transform(nanoseconds, parent, child, Pose(*pose)))

    def step_message(self, poses: RelativePoses) -> Optional[StepMessage]:
        """The transforms as a message that the core writes at each step.

        Args:
            poses: pose of each frame in its parent.

        Returns:
            None if the transport cannot do this: `send` has to be called.
        """
        return None


class TransformSender(ABC):
    """Sends transforms to one topic: a transport to `/tf`."""

    @property
    @abstractmethod
    def transforms_have_subscribers(self) -> bool:
        """True if the topic of transforms has a subscriber."""

    @abstractmethod
    def send_transform(self, transform: Transform) -> None:
        """Adds a transform to those of the present step; the transport's `flush` sends them.

        Args:
            transform: transform at one time.
        """

    def open_frames(self, names: Sequence[Tuple[str, str]]) -> Frames:
        """Prepares to send the transforms of frames.

        Args:
            names: the parent and the child of each frame.
        """
        return Frames(self, names)


class Transport(TransformSender):
    """Carries topics, transforms and parameters. All names include their namespace.

    Attributes:
        tf_by_namespace: whether each namespace of models has transforms of its own, on the topics
            `<namespace>/tf` and `<namespace>/tf_static`, and frames without the namespace. To be
            set before a world is loaded.
        activity: counts messages to be delivered, and changes of subscribers. While it stays the
            same, `process` and `flush` have nothing to do. NaN, which equals nothing, if a
            transport does not know.
        arrivals: the subscriptions with a message since the last step.
        on_input: if set, called with what comes to plugins from outside: a topic and a message, or
            the names of a model and its plugin and the values of a command.
        on_flush: called by `flush`, to publish what plugins have collected in the step.
        returns_on_arrival: whether `process` returns once callbacks have run, instead of waiting
            for its timeout.
    """

    def __init__(self) -> None:
        self.activity = math.nan
        self.arrivals = Arrivals()
        self.on_input: Optional[Callable[[Recipient, Any], None]] = None
        self.on_flush: List[Callable[[], None]] = []
        self.returns_on_arrival = False
        self.tf_by_namespace = False

    @property
    def sends_bytes(self) -> bool:
        """True if messages leave as bytes, which the core may write; each step ends by a flush."""
        return False

    @property
    def node_name(self) -> str:
        """The absolute name of the server's node, below which it has topics of its own."""
        return "/flatland_server"

    def resolve(self, name: str) -> str:
        """The absolute name of a topic.

        Args:
            name: with or without "/" before it.
        """
        return name if name.startswith("/") else f"/{name}"

    @abstractmethod
    def advertise(
        self, topic: str, message_type: Any, *, latch: bool, queue_size: int
    ) -> Publisher:
        """Opens a topic for publishing; see `Node.advertise`.

        Args:
            topic: name of the topic, with or without a leading "/".
            message_type: the class of its messages.
            latch: whether new subscribers get the last message.
            queue_size: how many messages wait for a slow subscriber before the oldest is dropped.
        """

    @abstractmethod
    def subscribe(
        self, topic: str, message_type: Any, callback: Callable[[Any], None]
    ) -> Subscription:
        """Subscribes to a topic.

        Args:
            topic: name of the topic, with or without a leading "/".
            message_type: the class of its messages.
            callback: called by `process` with each message.
        """

    @property
    def subscriber_revision(self) -> object:
        """A value that changes whenever a topic gets or loses a subscriber.

        A transport that does not know returns another value each time.
        """
        return object()

    @property
    def has_to_deliver(self) -> bool:
        """True if `flush` has to run callbacks after the next step."""
        return False

    @abstractmethod
    def get_param(self, name: str, default: Any = None) -> Any:
        """The value of a parameter.

        Args:
            name: absolute name of the parameter, such as "/robot1/radius".
            default: the value if there is no such parameter.
        """

    @abstractmethod
    def process(self, timeout: float = 0.0) -> None:
        """Runs the callbacks of pending messages.

        Without a wait, a step follows at once, and nothing waits for its messages: they may be held
        back until its end, and a little longer.

        Args:
            timeout: how long to wait for further ones [s].
        """

    @abstractmethod
    def flush(self) -> None:
        """Sends what was collected during the step, and resets the count of arrivals."""

    def release(self) -> None:
        """Sends the messages that were held back."""

    def discard(self) -> None:
        """Drops the remains of the former world, such as messages that are not delivered yet."""
