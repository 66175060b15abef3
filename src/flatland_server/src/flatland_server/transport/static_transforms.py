"""The transforms of /tf_static, from all publishers of a transport, as one latched message.

ROS keeps one message of a node for later subscribers of a topic, whichever of the node's publishers
has sent it: the frames of the others would be missing.
"""

from typing import Any, Callable, Dict, List, Optional

from flatland_server.messages.message_types import get
from flatland_server.transport.transport import Publisher

TOPIC = "/tf_static"


class StaticTransforms:
    """Joins the messages of publishers.

    Args:
        open_publisher: opens the topic, latched; called when there is a first message.
        note_change: called after a change, so that `publish` is called at once or later.
    """

    def __init__(
        self, open_publisher: Callable[[], Publisher], note_change: Callable[[], None]
    ) -> None:
        self._open_publisher = open_publisher
        self._note_change = note_change
        self._publisher: Optional[Publisher] = None
        self._parts: List[_Part] = []
        self.is_changed = False
        """True if there is something to `publish`."""

    def advertise(self) -> Publisher:
        """A publisher; frames that it has sent stay until it is closed."""
        return _Part(self)

    @property
    def transforms(self) -> Dict[str, Any]:
        """The present geometry_msgs/TransformStamped, by the name of the child frame."""
        return {frame: each for part in self._parts for frame, each in part.transforms.items()}

    def publish(self) -> None:
        """Publishes all transforms as one message."""
        self.is_changed = False
        if self._publisher is None:
            self._publisher = self._open_publisher()
        message = get("tf2_msgs/TFMessage")  # takes 10 ms to import, and few worlds need it
        self._publisher.publish(message(list(self.transforms.values())))

    def _update(self, part: "_Part", is_closed: bool) -> None:
        """Puts a part at the end: what was sent last counts."""
        self._parts = [each for each in self._parts if each is not part]
        if not is_closed:
            self._parts.append(part)
        self.is_changed = True
        self._note_change()


class _Part(Publisher):
    """The frames of one publisher."""

    def __init__(self, static: StaticTransforms) -> None:
        self._static = static
        self.transforms: Dict[str, Any] = {}

    @property
    def has_subscribers(self) -> bool:
        return True  # those to come get the message, too

    def publish(self, message: Any) -> None:
        self.transforms.update({each.child_frame_id: each for each in message.transforms})
        self._static._update(self, is_closed=False)

    def close(self) -> None:
        if self.transforms:
            self.transforms = {}
            self._static._update(self, is_closed=True)
