"""The walls of all layers as one flatland_msgs/Walls, for the window."""

import struct
from typing import Any, Callable, List, Tuple

from flatland_server.arrays import Segments
from flatland_server.messages.message_types import get
from flatland_server.models.layer import LayerConfig

ColorRGBA = get("std_msgs/ColorRGBA")
Header = get("std_msgs/Header")
LayerWalls = get("flatland_msgs/LayerWalls")
Walls = get("flatland_msgs/Walls")

_LENGTH = struct.Struct("<I")


class LazyWalls(Walls):  # type: ignore[misc, valid-type]
    """A Walls message that is serialized when it is sent, hence never without subscribers.

    Args:
        write: writes the serialized message into a buffer. rospy calls it on a thread of its own
            when a subscriber connects to a latched topic, so it must not read what the simulation
            changes.
    """

    __slots__ = ["_write"]

    def __init__(self, write: Callable[[Any], None]) -> None:
        super().__init__()
        self._write = write

    def serialize(self, buff: Any) -> None:
        """Writes the message into a buffer; called by rospy."""
        self._write(buff)


def walls_of(layers: List[Tuple[LayerConfig, Segments]], frame_id: str) -> LazyWalls:
    """The walls of layers, to be serialized later.

    Args:
        layers: their entries, and segments of shape (n, 4), x1, y1, x2, y2 [m].
        frame_id: the world's frame id.
    """

    def write(buff: Any) -> None:
        Header(frame_id=frame_id).serialize(buff)
        buff.write(_LENGTH.pack(len(layers)))
        for config, segments in layers:
            # Without segments, their number is the last field.
            LayerWalls(
                name=config.names[0], color=ColorRGBA(*config.color), encloses=config.encloses
            ).serialize(buff)
            buff.seek(-_LENGTH.size, 1)
            buff.write(_LENGTH.pack(segments.size))
            buff.write(segments.astype("<f4").data.cast("B"))

    return LazyWalls(write)
