"""The seam between a plugin and the world outside.

A plugin speaks to a `Node`: it publishes, subscribes, sends transforms and reads parameters, all in
its model's namespace, and all of that goes away when its model does. Behind the node is a
`Transport`: `flatland_server.ros.ros_transport`, or, within this process alone,
`flatland_server.transport.local_transport`. So a plugin runs under roslaunch, in a unit test and in
a thousand worlds without a master. Callbacks run between steps, on the simulation's own thread.
"""

import logging
from abc import ABC, abstractmethod
from typing import Any, Callable, Dict, Iterable, List, Optional, Sequence, Set, Tuple

from flatland_server._deprecated import renamed
from flatland_server.geometry import Pose, Transform
from flatland_server.transport.message_writer import MessageWriter

logger = logging.getLogger(__name__)


class Publisher(ABC):
    """Sends messages to one topic."""

    @property
    @abstractmethod
    def has_subscribers(self) -> bool:
        """Whether anybody listens. Ask before you compute something only to publish it."""

    @abstractmethod
    def publish(self, message: Any) -> None:
        """Sends a message. It must not be changed afterwards."""

    def write(self, writer: MessageWriter, *values: Any) -> None:
        """Sends what a writer makes of values, in the form that is the quickest here.

        A transport need not do so if nobody listens.
        """
        self.publish(writer.message(*values))

    @abstractmethod
    def close(self) -> None:
        """Takes the topic away."""

    is_watched = renamed("is_watched", "has_subscribers")


class Subscription(ABC):
    """Receives the messages of one topic until it is closed."""

    @abstractmethod
    def close(self) -> None:
        """No callback comes after this."""


class Frames:
    """Frames whose transforms are sent together, each to a parent that stays the same.

    Args:
        transport: what carries them.
        names: the parent and the child of each.
    """

    def __init__(self, transport: "Transport", names: Sequence[Tuple[str, str]]) -> None:
        self._transport = transport
        self._names = names

    def send(self, nanoseconds: int, poses: Iterable[Tuple[float, float, float]]) -> None:
        """Sends their transforms at a time, one pose [m, m, rad] for each."""
        for (parent, child), pose in zip(self._names, poses):
            self._transport.send_transform(Transform(nanoseconds, parent, child, Pose(*pose)))


class Transport(ABC):
    """What carries topics, transforms and parameters. Names come with their namespace."""

    @abstractmethod
    def advertise(
        self, topic: str, message_type: Any, *, latch: bool, queue_size: int
    ) -> Publisher:
        """Opens a topic for sending."""

    @abstractmethod
    def subscribe(
        self, topic: str, message_type: Any, callback: Callable[[Any], None]
    ) -> Subscription:
        """Opens a topic for receiving; callbacks come in `process`."""

    @property
    @abstractmethod
    def transforms_have_subscribers(self) -> bool:
        """Whether anybody listens to transforms."""

    @property
    def subscriber_revision(self) -> object:
        """Another value than before if somebody has begun or ended to listen to something.

        A transport that cannot tell says so always.
        """
        return object()

    @abstractmethod
    def send_transform(self, transform: Transform) -> None:
        """Takes a transform along with the others of this step."""

    def open_frames(self, names: Sequence[Tuple[str, str]]) -> Frames:
        """Something that sends the transforms of these frames, (parent, child)."""
        return Frames(self, names)

    @abstractmethod
    def get_param(self, name: str, default: Any = None) -> Any:
        """A parameter's value, or the default."""

    @abstractmethod
    def process(self, timeout: float = 0.0) -> None:
        """Runs the callbacks that wait, and those that come within `timeout` [s]."""

    @abstractmethod
    def flush(self) -> None:
        """Sends what the step has collected."""


class FrameRegistry:
    """Who publishes which frame. TF is a tree: a frame with two parents jumps between them."""

    def __init__(self) -> None:
        self._owners: Dict[str, str] = {}
        self._parents: Dict[str, str] = {}
        self._warned: Set[Tuple[str, str]] = set()  # frames and their other publishers

    def claim(self, parent: str, child: str, owner: str) -> None:
        """Notes a frame's publisher; warns once if there is another one."""
        first = self._owners.setdefault(child, owner)
        if first == owner:
            self._parents[child] = parent
        elif (child, owner) not in self._warned:
            self._warned.add((child, owner))
            other = self._parents[child]
            conflict = f'from "{parent}"'
            if parent != other:
                conflict += f' and from "{other}", though a frame can have only one parent'
            logger.warning(
                'two plugins publish the frame "%s" %s: %s and %s; switch one of them off',
                *(child, conflict, first, owner),
            )

    def release(self, owner: str) -> None:
        """Forgets the frames of a publisher that is gone."""
        for child in [child for child, other in self._owners.items() if other == owner]:
            del self._owners[child]
        self._warned = {pair for pair in self._warned if pair[0] in self._owners}


class Node:
    """A plugin's access to topics, transforms and parameters.

    Args:
        transport: what carries them.
        namespace: put before each topic that does not begin with "/".
        owner: who this node belongs to, for warnings.
        frames: the frames of the whole world.
    """

    def __init__(
        self,
        transport: Transport,
        namespace: str = "",
        owner: str = "",
        frames: Optional[FrameRegistry] = None,
    ) -> None:
        self.namespace = namespace.strip("/")
        self._transport = transport
        self.owner = owner
        """Who it belongs to, `model/plugin` or the name of a plugin of the world."""
        self._frames = frames if frames is not None else FrameRegistry()
        self._publishers: List[Publisher] = []
        self._subscriptions: List[Subscription] = []
        self._is_closed = False
        self.on_failure: Optional[Callable[[str], None]] = None
        """Called with a description of the callback that has just raised an exception."""

    def scoped(self, namespace: str, owner: str) -> "Node":
        """A node for somebody else, in a namespace within this one's."""
        joined = "/".join(part for part in (self.namespace, namespace.strip("/")) if part)
        return Node(self._transport, joined, owner, self._frames)

    def resolve(self, name: str) -> str:
        """A topic's or parameter's name with the namespace; absolute names stay as they are."""
        return name if name.startswith("/") or not self.namespace else f"{self.namespace}/{name}"

    def advertise(
        self, topic: str, message_type: Any, *, latch: bool = False, queue_size: int = 10
    ) -> Publisher:
        """Opens a topic for sending.

        Args:
            topic: its name within the namespace.
            message_type: the ROS message class.
            latch: whether late listeners get the last message.
            queue_size: how many messages wait for a slow listener before the oldest is dropped.
        """
        publisher = self._transport.advertise(
            self.resolve(topic), message_type, latch=latch, queue_size=queue_size
        )
        self._publishers.append(publisher)
        return publisher

    def subscribe(
        self, topic: str, message_type: Any, callback: Callable[[Any], None]
    ) -> Subscription:
        """Calls `callback(message)` between steps for each message of a topic."""
        name = self.resolve(topic)

        def guarded(message: Any) -> None:
            if self._is_closed:
                return
            on_failure = self.on_failure  # the callback may close this node
            try:
                callback(message)
            except Exception:
                if on_failure is None:
                    raise
                on_failure(f"its callback of {name}")

        subscription = self._transport.subscribe(name, message_type, guarded)
        self._subscriptions.append(subscription)
        return subscription

    @property
    def transforms_have_subscribers(self) -> bool:
        """Whether anybody listens to transforms."""
        return self._transport.transforms_have_subscribers

    @property
    def subscriber_revision(self) -> object:
        """Another value than before if somebody has begun or ended to listen to something."""
        return self._transport.subscriber_revision

    transforms_are_watched = renamed("transforms_are_watched", "transforms_have_subscribers")
    listeners_version = renamed("listeners_version", "subscriber_revision")

    def claim_frame(self, parent: str, child: str) -> None:
        """Says that this node will publish a frame; warns if somebody else does."""
        self._frames.claim(parent, child, self.owner)

    def open_frames(self, *names: Tuple[str, str]) -> Frames:
        """Says that this node will publish frames, given as (parent, child), and lets it do so.

        Quicker than `send_transform` for what is sent at every step.
        """
        for parent, child in names:
            self.claim_frame(parent, child)
        return self._transport.open_frames(names)

    def send_transform(self, transform: Transform) -> None:
        """Sends a transform, together with all others of this step."""
        self._frames.claim(transform.parent, transform.child, self.owner)
        self._transport.send_transform(transform)

    def get_param(self, name: str, default: Any = None) -> Any:
        """A parameter's value within the namespace, or the default."""
        return self._transport.get_param(self.resolve(name), default)

    def close(self) -> None:
        """Takes away all that this node opened; no callback comes any more."""
        self._is_closed = True
        for publisher in self._publishers:
            publisher.close()
        for subscription in self._subscriptions:
            subscription.close()
        self._publishers.clear()
        self._subscriptions.clear()
        self.on_failure = None  # it refers to the plugin, which refers to this node
        self._frames.release(self.owner)
