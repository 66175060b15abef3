"""The senders of transforms: all of a step in one message on a topic `tf`, and `/tf_static`.

A transport has a `TransformQueue` for /tf. A node in a namespace may have a topic of its own, see
`Transport.tf_by_namespace`. ROS keeps one message of a node for later subscribers of a topic,
whichever of the node's publishers has sent it: so `StaticTransforms` joins their frames.
"""

import math
import struct
from typing import Any, Callable, Dict, Iterable, List, Optional, Sequence, Tuple

from flatland_server._core import BodyMessage, RelativePoses, StepMessage, TransformList
from flatland_server.config.ros_names import tf_topics
from flatland_server.geometry import Transform, quaternion
from flatland_server.messages.conversions import stamp_of
from flatland_server.messages.message_types import deserialized, get
from flatland_server.transport.transport import (
    Frames,
    MessageWriter,
    Publisher,
    TransformSender,
    Transport,
)

TF_STATIC = "/tf_static"

_HEADER = struct.Struct("<III")  # seq, secs, nsecs
_POSE = struct.Struct("<7d")


class TransformQueue:
    """Collects the serialized transforms of a step; caches the serialized names of frames."""

    def __init__(self) -> None:
        self._names: Dict[Tuple[str, str], bytes] = {}
        self.list = TransformList()
        """The transforms; the core adds to it, too."""
        self.take = self.list.take
        """Returns and forgets the collected transforms as a message; empty if there are none."""

    def add(self, transform: Transform) -> None:
        """Appends a transform."""
        pose = transform.pose
        rotation = quaternion(pose.yaw, transform.roll)
        self.list.add(
            1,
            _HEADER.pack(0, *stamp_of(transform.nanoseconds))
            + self.names_of(transform.parent, transform.child)
            + _POSE.pack(pose.x, pose.y, 0.0, *rotation),
        )

    def names_of(self, parent: str, child: str) -> bytes:
        """The serialized names of two frames, which follow the stamp in a transform."""
        names = self._names.get((parent, child))
        if names is None:
            encoded = [name.encode() for name in (parent, child)]
            names = b"".join(struct.pack("<I", len(name)) + name for name in encoded)
            self._names[parent, child] = names
        return names


class SerializedFrames(Frames):
    """Frames serialized in advance, except for their stamps and poses.

    Args:
        queue: queue that gets the transforms.
        names: (parent, child) of each frame.
    """

    def __init__(self, queue: TransformQueue, names: Sequence[Tuple[str, str]]) -> None:
        self._queue = queue
        self._data = bytearray()
        self._offsets: List[Tuple[int, int]] = []  # of stamps and of poses
        for parent, child in names:
            serialized_names = queue.names_of(parent, child)
            begin = len(self._data)
            self._offsets.append((begin, begin + _HEADER.size + len(serialized_names)))
            self._data += bytes(_HEADER.size) + serialized_names + bytes(_POSE.size)
        self._poses: Optional[RelativePoses] = None
        self._message: Optional[BodyMessage] = None  # with these poses

    def send(self, nanoseconds: int, poses: Iterable[Tuple[float, float, float]]) -> None:
        if isinstance(poses, RelativePoses):
            self._queue.list.add(len(self._offsets), self._message_of(poses).data(nanoseconds))
            return
        seconds, rest = stamp_of(nanoseconds)
        data = self._data
        for (stamp, pose), (x, y, yaw) in zip(self._offsets, poses):
            half = yaw / 2
            _HEADER.pack_into(data, stamp, 0, seconds, rest)
            _POSE.pack_into(data, pose, x, y, 0.0, 0.0, 0.0, math.sin(half), math.cos(half))
        self._queue.list.add(len(self._offsets), bytes(data))

    def step_message(self, poses: RelativePoses) -> StepMessage:
        return StepMessage(self._message_of(poses), self._queue.list)

    def _message_of(self, poses: RelativePoses) -> BodyMessage:
        if self._message is None or poses is not self._poses:
            fields = [(stamp, pose, None) for stamp, pose in self._offsets]
            self._message = BodyMessage(bytes(self._data), poses, fields, is_numbered=False)
            self._poses = poses
        return self._message


class NamespaceTransforms(TransformSender):
    """Collects the transforms of a step, which leave as one message. Opens the topic if it is used.

    Args:
        transport: transport on which the topic is published.
        namespace: of the topic, not empty.
    """

    def __init__(self, transport: Transport, namespace: str) -> None:
        self._transport = transport
        self._topic, _ = tf_topics(namespace)
        self._publisher: Optional[Publisher] = None
        self._queue = TransformQueue()

    @property
    def transforms_have_subscribers(self) -> bool:
        return self._opened().has_subscribers

    def send_transform(self, transform: Transform) -> None:
        self._opened()
        self._queue.add(transform)

    def open_frames(self, names: Sequence[Tuple[str, str]]) -> Frames:
        self._opened()
        if self._transport.sends_bytes:
            return SerializedFrames(self._queue, names)
        return super().open_frames(names)

    def close(self) -> None:
        """Closes the topic."""
        if self._publisher is not None:
            self._transport.on_flush.remove(self._flush)
            self._publisher.close()
            self._publisher = None

    def _opened(self) -> Publisher:
        if self._publisher is None:
            self._publisher = self._transport.advertise(
                self._topic, get("tf2_msgs/TFMessage"), latch=False, queue_size=100
            )
            self._transport.on_flush.append(self._flush)
        return self._publisher

    def _flush(self) -> None:
        data = self._queue.take()
        if data:
            self._opened().write(_WRITER, data)


class _Writer(MessageWriter):
    def message(self, *values: Any) -> Any:
        return deserialized(get("tf2_msgs/TFMessage"), *values)

    def data(self, *values: Any) -> bytes:
        data: bytes = values[0]
        return data


_WRITER = _Writer()


class StaticTransforms:
    """The frames of all publishers of a topic `tf_static`, as one latched message.

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
