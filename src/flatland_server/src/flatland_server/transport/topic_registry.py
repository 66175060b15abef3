"""The topics of plugins, and their types.

ROS lets nodes publish messages of two types to one topic; a subscriber then gets messages that it
cannot read. A plugin that publishes to `/clock` or `/tf` disturbs every node. Both are refused
here, with a message that names the other publisher or subscriber.
"""

from typing import Any, Dict, List, Tuple

from flatland_server.config.ros_names import TOPIC, is_topic
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
