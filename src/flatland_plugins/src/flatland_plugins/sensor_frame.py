"""The frame of a sensor that is mounted on a body."""

from typing import Any, Optional

from flatland_server import (
    ModelBody,
    ModelPlugin,
    Pose,
    Transform,
    YamlReader,
    header,
    messages,
    quaternion,
)

TFMessage = messages.get("tf2_msgs/TFMessage")
TransformStamped = messages.get("geometry_msgs/TransformStamped")


def static_by_default(plugin: ModelPlugin) -> bool:
    """The default of the key `static_tf`: the server's parameter."""
    return bool(plugin.node.get_param("~static_tf", False))


def read_tf_topic(config: YamlReader, static: bool) -> Optional[str]:
    """Reads the topic of a sensor's transform; None if it is not published.

    Args:
        config: the plugin's entry in the model file.
        static: the default of the key `static_tf`.
    """
    is_broadcast = config.get_bool("broadcast_tf", True)
    topic = "/tf_static" if config.get_bool("static_tf", static) else "/tf"
    return topic if is_broadcast else None


class SensorFrame:
    """Publishes the transform from a body to a sensor on it.

    Once on /tf_static, or with each measurement on /tf, as the original does.

    Args:
        plugin: the plugin of the sensor.
        body: the body it is mounted on.
        frame: name of its frame, without the model's namespace.
        tf_topic: of the transform; None if it is not published.
        pose: of the sensor, in the body's frame.
        roll: of the sensor, about the body's x axis [rad].
    """

    def __init__(
        self,
        plugin: ModelPlugin,
        body: ModelBody,
        frame: str,
        tf_topic: Optional[str],
        pose: Pose = Pose(),  # noqa: B008 (immutable)
        roll: float = 0.0,
    ) -> None:
        self.name = plugin.name_space_tf(frame)
        """With the model's namespace."""
        self._node = plugin.node
        self._parent = plugin.name_space_tf(body.name)
        self._is_sent = tf_topic == "/tf"
        self._pose = pose
        self._roll = roll
        if tf_topic is not None:
            self._node.claim_frame(self._parent, self.name)
        if tf_topic == "/tf_static":
            publisher = self._node.advertise(tf_topic, TFMessage, latch=True)
            publisher.publish(TFMessage([self._static_transform()]))

    @property
    def has_subscribers(self) -> bool:
        """True if the transform is sent with measurements, and transforms have a subscriber."""
        return self._is_sent and self._node.transforms_have_subscribers

    def publish(self, nanoseconds: int) -> None:
        """Sends the transform, if transforms have a subscriber."""
        if self.has_subscribers:
            self._node.send_transform(
                Transform(nanoseconds, self._parent, self.name, self._pose, self._roll)
            )

    def _static_transform(self) -> Any:
        static = TransformStamped(header=header(0, self._parent), child_frame_id=self.name)
        translation, rotation = static.transform.translation, static.transform.rotation
        translation.x, translation.y = self._pose.x, self._pose.y
        rotation.x, rotation.y, rotation.z, rotation.w = quaternion(self._pose.yaw, self._roll)
        return static
