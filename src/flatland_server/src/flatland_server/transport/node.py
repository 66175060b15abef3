"""A plugin's access to topics, transforms and parameters, the same for all transports.

Since a plugin knows only its node, it runs unchanged under roslaunch, in a unit test and in a
program without a ROS master. Callbacks run between steps, on the thread of the simulation.
"""

from typing import Any, Callable, List, NamedTuple, Optional, Tuple

from flatland_server.config.ros_names import namespaced_frame
from flatland_server.config.yaml_map import warn_once
from flatland_server.exceptions import PLUGIN_ERRORS, TopicError
from flatland_server.geometry import Transform
from flatland_server.messages.message_types import get
from flatland_server.transport.claims import FrameRegistry, TopicRegistry, type_name
from flatland_server.transport.transforms import TF_STATIC, NamespaceTransforms
from flatland_server.transport.transport import (
    Frames,
    Publisher,
    Subscription,
    TransformSender,
    Transport,
)


class NodeTopic(NamedTuple):
    """A topic that a plugin uses."""

    name: str
    """Absolute."""
    type: str
    """Such as `sensor_msgs/LaserScan`."""
    is_published: bool
    """True if the plugin publishes it; otherwise it subscribes to it."""


class Node:
    """The topics, transforms and parameters of one plugin, in the namespace of its model.

    When the plugin ends, the node is closed with all of its topics and frames.

    Args:
        transport: transport of the topics and transforms.
        namespace: put before each name that does not begin with "/".
        owner: the name of the plugin, for warnings.
        frames: the frames of the whole world, to find those with several publishers.
        topics: the topics of the whole world, to refuse a second type for a topic.
    """

    def __init__(
        self,
        transport: Transport,
        namespace: str = "",
        owner: str = "",
        frames: Optional[FrameRegistry] = None,
        topics: Optional[TopicRegistry] = None,
    ) -> None:
        self.namespace = namespace.strip("/")
        self._transport = transport
        self.owner = owner
        """The plugin: `model/plugin`, or the name of a plugin of the world."""
        self._frames = frames if frames is not None else FrameRegistry()
        self._topics = topics if topics is not None else TopicRegistry(transport)
        self._own_tf: Optional[NamespaceTransforms] = None
        if self.namespace and transport.tf_by_namespace:
            self._own_tf = NamespaceTransforms(transport, self.namespace)
            self._frames = self._frames.within(self.namespace)
        self._tf: TransformSender = self._own_tf or transport
        self._publishers: List[Publisher] = []
        self._subscriptions: List[Subscription] = []
        self._used_topics: List[NodeTopic] = []
        self._is_closed = False
        self.on_failure: Optional[Callable[[str], None]] = None
        """Called while the exception of a callback is being handled, with a description of the
        callback. Without it, the exception is raised."""
        self.warn: Callable[[str], None] = warn_once
        """Logs a warning, once; for the plugin of a file with its place in it."""

    def scoped(self, namespace: str, owner: str) -> "Node":
        """A node for another plugin.

        Args:
            namespace: within the namespace of this node.
            owner: name of that plugin, for warnings.
        """
        joined = "/".join(part for part in (self.namespace, namespace.strip("/")) if part)
        return Node(self._transport, joined, owner, self._frames, self._topics)

    def name_frame(self, frame_id: str) -> str:
        """The name of a frame within the namespace: `<namespace>_<frame>`.

        Without a namespace, or if each one has transforms of its own, it stays as it is.

        Args:
            frame_id: name of the frame, without the namespace.
        """
        return frame_id if self._own_tf else namespaced_frame(self.namespace, frame_id)

    def resolve(self, name: str) -> str:
        """The name of a topic or parameter with the namespace.

        Args:
            name: stays as it is if it begins with "/", or with "~", as a parameter of the server.
        """
        is_absolute = name.startswith(("/", "~")) or not self.namespace
        return name if is_absolute else f"{self.namespace}/{name}"

    def advertise(
        self, topic: str, message_type: Any, *, latch: bool = False, queue_size: int = 10
    ) -> Publisher:
        """Opens a topic for publishing.

        Args:
            topic: its name within the namespace.
            message_type: the name of the type, such as "sensor_msgs/LaserScan", or its class.
            latch: whether new subscribers get the last message.
            queue_size: how many messages wait for a slow subscriber before the oldest is dropped.

        Raises:
            MessageError: there is no such message type.
            TopicError: ROS cannot have a topic of this name, it is one of the server's own, or
                another plugin has it with another type.
        """
        message_type = _class_of(message_type)
        if topic == TF_STATIC and self._own_tf:
            topic = TF_STATIC[1:]
        name = self._named(topic, self._topics.claim_publisher, message_type)
        publisher = self._transport.advertise(
            name, message_type, latch=latch, queue_size=queue_size
        )
        self._publishers.append(publisher)
        self._note_topic(name, message_type, is_published=True)
        return publisher

    def subscribe(
        self, topic: str, message_type: Any, callback: Callable[[Any], None]
    ) -> Subscription:
        """Subscribes to a topic.

        Args:
            topic: its name within the namespace.
            message_type: the name of the type, such as "sensor_msgs/LaserScan", or its class.
            callback: called with each message, between steps.

        Raises:
            MessageError: there is no such message type.
            TopicError: ROS cannot have a topic of this name, or it has another type already.
        """
        message_type = _class_of(message_type)
        name = self._named(topic, self._topics.claim_subscriber, message_type)

        def guarded(message: Any) -> None:
            if self._is_closed:
                return
            on_failure = self.on_failure  # the callback may close this node
            try:
                callback(message)
            except PLUGIN_ERRORS:
                if on_failure is None:
                    raise
                on_failure(f"its callback of {name}")

        subscription = self._transport.subscribe(name, message_type, guarded)
        self._subscriptions.append(subscription)
        self._note_topic(name, message_type, is_published=False)
        return subscription

    @property
    def topics(self) -> List[NodeTopic]:
        """The topics that this plugin has opened, in that order; none once it is closed."""
        return list(self._used_topics)

    def _note_topic(self, name: str, message_type: Any, is_published: bool) -> None:
        topic = NodeTopic(self._transport.resolve(name), type_name(message_type), is_published)
        if topic not in self._used_topics:
            self._used_topics.append(topic)

    def _named(self, topic: str, claim: Callable[[str, Any, str], None], message_type: Any) -> str:
        """Claims a topic, and returns its name with the namespace."""
        try:
            claim(self.resolve(topic), message_type, self.owner)
        except TopicError as error:
            raise TopicError(str(error), topic) from None
        return self.resolve(topic)

    @property
    def transforms_have_subscribers(self) -> bool:
        """True if the topic of transforms has a subscriber."""
        return self._tf.transforms_have_subscribers

    def claim_frame(self, parent: str, child: str) -> None:
        """Announces that this node publishes a frame; warns if another one does already.

        Args:
            parent: parent frame of the transform.
            child: frame that this node publishes.

        Raises:
            TopicError: TF cannot have a frame of this name.
        """
        self._frames.claim(parent, child, self.owner, self.warn)

    def claim_odometry_frame(self, frame_id: str) -> None:
        """Announces that this node publishes a model's transform from a frame of odometry.

        Such a frame is of one model alone; warns if a node of another model has announced it.

        Args:
            frame_id: name of the odometry frame.
        """
        self._frames.claim_odometry(frame_id, self.owner, self.warn)

    def open_frames(self, *names: Tuple[str, str]) -> Frames:
        """Claims frames, and prepares to send their transforms.

        Faster than `send_transform` for transforms that are sent at every step.

        Args:
            names: the parent and the child of each frame.
        """
        for parent, child in names:
            self.claim_frame(parent, child)
        return self._tf.open_frames(names)

    def send_transform(self, transform: Transform) -> None:
        """Sends a transform, together with all others of the step.

        Args:
            transform: transform at one time.
        """
        self._frames.claim(transform.parent, transform.child, self.owner, self.warn)
        self._tf.send_transform(transform)

    def get_param(self, name: str, default: Any = None) -> Any:
        """The value of a parameter.

        Args:
            name: within the namespace, or "~name" for a private parameter of the server.
            default: the value if there is no such parameter.
        """
        return self._transport.get_param(self.resolve(name), default)

    def close(self) -> None:
        """Closes all topics and frames of this node; no callback is called any more."""
        self._is_closed = True
        for publisher in self._publishers:
            publisher.close()
        for subscription in self._subscriptions:
            subscription.close()
        if self._own_tf is not None:
            self._own_tf.close()
        self._publishers.clear()
        self._subscriptions.clear()
        self._used_topics.clear()
        self.on_failure = None  # it refers to the plugin, which refers to this node
        self._frames.release(self.owner)
        self._topics.release(self.owner)


def _class_of(message_type: Any) -> Any:
    """The class of a message type that is given by its name or as a class."""
    return get(message_type) if isinstance(message_type, str) else message_type
