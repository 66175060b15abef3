"""The frame of a sensor that is mounted on a body."""

from flatland_server import ModelBody, ModelPlugin, Pose, Transform


class SensorFrame:
    """Publishes the transform from a body to a sensor on it, if `broadcast` is set.

    Args:
        plugin: the sensor.
        body: the body it is mounted on.
        frame: its frame, without the model's namespace.
        broadcast: whether the transform is published.
        pose: of the sensor, in the body's frame.
        roll: of the sensor, about the body's x axis [rad].
    """

    def __init__(
        self,
        plugin: ModelPlugin,
        body: ModelBody,
        frame: str,
        broadcast: bool,
        pose: Pose = Pose(),  # noqa: B008 (immutable)
        roll: float = 0.0,
    ) -> None:
        self.name = plugin.name_space_tf(frame)
        """With the model's namespace."""
        self._node = plugin.node
        self._parent = plugin.name_space_tf(body.name)
        self._broadcast = broadcast
        self._pose = pose
        self._roll = roll
        if broadcast:
            self._node.claim_frame(self._parent, self.name)

    @property
    def has_subscribers(self) -> bool:
        """True if the transform is published, and transforms have a subscriber."""
        return self._broadcast and self._node.transforms_have_subscribers

    def publish(self, nanoseconds: int) -> None:
        """Sends the transform, if transforms have a subscriber."""
        if self.has_subscribers:
            self._node.send_transform(
                Transform(nanoseconds, self._parent, self.name, self._pose, self._roll)
            )
