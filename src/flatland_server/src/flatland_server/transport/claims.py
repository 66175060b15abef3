"""The topics and frames that plugins claim: each topic has one type, each frame one publisher.

ROS lets nodes publish messages of two types to one topic; a subscriber then gets messages that it
cannot read. A plugin that publishes to `/clock` or `/tf` disturbs every node. Both are refused,
with a message that names the other plugin. A frame with two publishers is a warning.
"""

from typing import Any, Callable, Dict, List, Set, Tuple
from weakref import WeakValueDictionary

from flatland_server.config.ros_names import FRAME, TOPIC, is_frame, is_topic
from flatland_server.exceptions import TopicError, shortened
from flatland_server.transport.transport import Transport

ANY_TYPE = "*"
"""The type of `rospy.AnyMsg`, for a subscriber that takes messages of every type."""

_TYPES = {
    "/clock": "rosgraph_msgs/Clock",
    "/tf": "tf2_msgs/TFMessage",
    "/tf_static": "tf2_msgs/TFMessage",
    "/rosout": "rosgraph_msgs/Log",
    "/rosout_agg": "rosgraph_msgs/Log",
    "/diagnostics": "diagnostic_msgs/DiagnosticArray",
}
_OF_SERVER = {"/clock", "/tf", "/rosout", "/diagnostics"}
"""Topics to which plugins publish through the server alone, if at all."""
_OF_NODE = ("debug", "loading", "model_states", "models", "state")
"""The same, in the namespace of the server's node."""

OdometryFrame = Tuple[str, str]
"""The namespace of the transforms, empty for `/tf`; and the frame."""

Warn = Callable[[str], None]
"""Logs a warning at the place of a plugin in its file, once."""


class TopicRegistry:
    """The topics of all plugins of a world.

    Args:
        transport: resolves names, and knows the name of the server's node.
    """

    def __init__(self, transport: Transport) -> None:
        self._transport = transport
        self._types: Dict[str, Tuple[str, List[str]]] = {}  # with the plugins that use the topic
        self._topics: Dict[str, List[str]] = {}  # by plugin

    def claim_publisher(self, topic: str, message_type: Any, plugin: str) -> None:
        """Registers a plugin as a publisher of a topic.

        Raises:
            TopicError: the topic is not a name that ROS can have, is the server's own, or has
                another type already.
        """
        name = self._resolved(topic)
        if self._is_of_server(name):
            kind = f" ({_TYPES[name]})" if name in _TYPES else ""
            raise TopicError(f'the topic "{name}" is the server\'s own{kind}', topic)
        self._claim(topic, name, type_name(message_type), plugin)

    def claim_subscriber(self, topic: str, message_type: Any, plugin: str) -> None:
        """Registers a plugin as a subscriber of a topic.

        Raises:
            TopicError: the topic is not a name that ROS can have, or has another type already.
        """
        name = self._resolved(topic)
        if type_name(message_type) != ANY_TYPE:
            self._claim(topic, name, type_name(message_type), plugin)

    @property
    def types(self) -> Dict[str, str]:
        """The types of the topics by their absolute names, in the order of the names."""
        return {name: self._types[name][0] for name in sorted(self._types)}

    def owners_of(self, topic: str) -> List[str]:
        """The plugins that publish or subscribe to a topic, by its absolute name."""
        return list(self._types[topic][1]) if topic in self._types else []

    def release(self, plugin: str) -> None:
        """Removes a plugin from all its topics."""
        for name in self._topics.pop(plugin, []):
            plugins = self._types[name][1]
            plugins.remove(plugin)
            if not plugins:
                del self._types[name]

    def _resolved(self, topic: str) -> str:
        if not is_topic(topic):
            raise TopicError(f'expected {TOPIC}, found "{shortened(topic)}"', topic)
        return self._transport.resolve(topic)

    def _is_of_server(self, name: str) -> bool:
        node = self._transport.node_name
        markers = self._transport.resolve("interactive_model_markers")
        if name.startswith(f"{node}/"):
            own = name[len(node) + 1 :]
            return own in _OF_NODE or own.startswith("debug/")
        return name in _OF_SERVER or name == markers or name.startswith(f"{markers}/")

    def _claim(self, topic: str, name: str, kind: str, plugin: str) -> None:
        known = _TYPES.get(name)
        if known not in (None, kind):
            raise TopicError(f'the topic "{name}" has the type {known}, not {kind}', topic)
        first, plugins = self._types.setdefault(name, (kind, []))
        if first != kind:
            raise TopicError(
                f'the topic "{name}" has the type {first}, of the plugin {plugins[0]}, not {kind}',
                topic,
            )
        plugins.append(plugin)
        self._topics.setdefault(plugin, []).append(name)


def type_name(message_type: Any) -> str:
    """The name of a message class, such as `sensor_msgs/LaserScan`."""
    name = getattr(message_type, "_type", None) or getattr(message_type, "__name__", None)
    return str(name or message_type)


class FrameRegistry:
    """Finds frames with several publishers, and frames of odometry that several models share.

    TF is a tree: a frame with two publishers would jump between their poses. And if two robots
    share a frame of odometry, a localiser that corrects the odometry of one of them moves both.

    With transforms by namespace there is one such tree for each, and the registry of it lives as
    long as a node that has it.
    """

    def __init__(self) -> None:
        self._publishers: Dict[str, str] = {}  # by frame
        self._parents: Dict[str, str] = {}
        self._frames: Dict[str, List[str]] = {}  # by publisher
        # A frame and its second publisher; "" if it is one of odometry.
        self._warned: Set[Tuple[str, str]] = set()
        self._odometry: Dict[str, Dict[str, None]] = {}  # publishers by frame, in their order
        self._odometry_of: Dict[str, List[str]] = {}  # the same frames by publisher
        self._namespaces: WeakValueDictionary[str, FrameRegistry] = WeakValueDictionary()

    def within(self, namespace: str) -> "FrameRegistry":
        """The registry of a namespace that has transforms of its own.

        Args:
            namespace: not empty.
        """
        return self._namespaces.setdefault(namespace, FrameRegistry())

    def claim(self, parent: str, child: str, publisher: str, warn: Warn) -> None:
        """Registers the publisher of a frame; warns once if there is another one already.

        Args:
            parent: parent frame of the transform.
            child: child frame of the transform.
            publisher: a plugin, as `model/plugin` or the name of a plugin of the world.
            warn: called with the text of a warning.

        Raises:
            TopicError: TF cannot have a frame of one of these names.
        """
        if child not in self._publishers:
            for frame in (parent, child):
                if not is_frame(frame):
                    raise TopicError(f'expected {FRAME}, found "{shortened(frame)}"', frame)
        first = self._publishers.setdefault(child, publisher)
        if first == publisher:
            if child not in self._parents:
                self._frames.setdefault(publisher, []).append(child)
            self._parents[child] = parent
        elif (child, publisher) not in self._warned:
            self._warned.add((child, publisher))
            other = self._parents[child]
            conflict = f'two plugins publish the frame "{child}" from "{parent}"'
            if parent != other:
                conflict += f' and from "{other}", though a frame can have only one parent'
            advice = "switch one of them off"
            if _model_of(first) != _model_of(publisher):
                advice = "give each model in the world file a namespace of its own"
            warn(f"{conflict}: {first} and {publisher}; {advice}")

    def claim_odometry(self, frame_id: str, publisher: str, warn: Warn) -> None:
        """Registers the publisher of a transform from a frame of odometry to a model.

        Warns once for each frame if a plugin of another model has registered it already.

        Args:
            frame_id: the frame that odometry starts from, such as "odom".
            publisher: a plugin, as `model/plugin`.
            warn: called with the text of a warning.
        """
        publishers = self._odometry.setdefault(frame_id, {})
        if publisher not in publishers:
            publishers[publisher] = None
            self._odometry_of.setdefault(publisher, []).append(frame_id)
        first = next(iter(publishers))
        key = (frame_id, "")
        if _model_of(first) == _model_of(publisher) or key in self._warned:
            return
        self._warned.add(key)
        warn(
            f'two models share the odometry frame "{frame_id}": {first} and {publisher} publish '
            'transforms from it; write "odom_frame_id: ~odom" in the model file and give each '
            "model a namespace, so that each has a frame <namespace>_odom"
        )

    @property
    def odometry_frames(self) -> Set[OdometryFrame]:
        """The frames of odometry in use, those of namespaces included."""
        frames = {("", frame) for frame in self._odometry}
        for namespace, registry in list(self._namespaces.items()):
            frames |= {(namespace, frame) for frame in registry._odometry}
        return frames

    def release(self, publisher: str) -> None:
        """Removes the frames of a publisher."""
        children = self._frames.pop(publisher, [])
        for child in children:
            del self._publishers[child]
            del self._parents[child]
        if children and self._warned:
            self._warned = {pair for pair in self._warned if pair[0] in self._publishers}
        for frame_id in self._odometry_of.pop(publisher, []):
            publishers = self._odometry[frame_id]
            del publishers[publisher]
            if not publishers:
                del self._odometry[frame_id]


def _model_of(publisher: str) -> str:
    return publisher.rpartition("/")[0]
