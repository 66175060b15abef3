"""The transforms of a node in a namespace, on `<namespace>/tf`: see `Transport.tf_by_namespace`."""

from typing import Any, Optional, Sequence, Tuple

from flatland_server.config.ros_names import tf_topics
from flatland_server.geometry import Transform
from flatland_server.messages.message_types import deserialized, get
from flatland_server.transport.serialized_transforms import SerializedFrames, TransformQueue
from flatland_server.transport.transport import (
    Frames,
    MessageWriter,
    Publisher,
    TransformSender,
    Transport,
)


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
