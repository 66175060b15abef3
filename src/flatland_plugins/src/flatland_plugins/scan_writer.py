"""LaserScan messages from arrays."""

import struct
from typing import Any

from flatland_server import Float32Array, MessageWriter, header, messages, stamp_of

LaserScan = messages.get("sensor_msgs/LaserScan")

_CONSTANT_FIELDS = (
    *("angle_min", "angle_max", "angle_increment"),
    *("time_increment", "scan_time", "range_min", "range_max"),
)
"""In the order of the message."""


class ScanWriter(MessageWriter):
    """Makes LaserScans that differ in their times, ranges and intensities alone."""

    def __init__(self, frame_id: str, **fields: float) -> None:
        self._frame_id = frame_id
        self._fields = fields
        self._sequence = 0
        frame = frame_id.encode()
        self._constant = (
            struct.pack("<I", len(frame))
            + frame
            + struct.pack("<7f", *(fields.get(name, 0.0) for name in _CONSTANT_FIELDS))
        )

    def message(self, nanoseconds: int, ranges: Float32Array, intensities: Float32Array) -> Any:
        """A LaserScan with arrays for ranges and intensities."""
        return LaserScan(
            header=header(nanoseconds, self._frame_id),
            ranges=ranges,
            intensities=intensities,
            **self._fields,
        )

    def data(self, nanoseconds: int, ranges: Float32Array, intensities: Float32Array) -> bytes:
        """The same as bytes, field by field as LaserScan has them."""
        self._sequence += 1
        return b"".join(
            (
                struct.pack("<3I", self._sequence, *stamp_of(nanoseconds)),
                self._constant,
                struct.pack("<I", len(ranges)),
                ranges.astype("<f4", copy=False).tobytes(),
                struct.pack("<I", len(intensities)),
                intensities.astype("<f4", copy=False).tobytes(),
            )
        )
