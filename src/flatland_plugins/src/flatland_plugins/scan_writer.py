"""LaserScan messages from arrays."""

import struct
from typing import Any

from flatland_server import Float32Array, MessageWriter, header, messages

LaserScan = messages.get("sensor_msgs/LaserScan")


class ScanWriter(MessageWriter):
    """Makes LaserScans that differ in their times, ranges and intensities alone.

    Args:
        frame_id: of the lidar.
        fields: the other fields of a LaserScan.
    """

    def __init__(self, frame_id: str, **fields: float) -> None:
        self._frame_id = frame_id
        self._fields = fields
        self._sequence = 0
        constant = LaserScan(**fields)
        frame = frame_id.encode()
        self._constant = (
            struct.pack("<I", len(frame))
            + frame
            + struct.pack(
                "<7f",
                *(constant.angle_min, constant.angle_max, constant.angle_increment),
                *(constant.time_increment, constant.scan_time),
                *(constant.range_min, constant.range_max),
            )
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
        seconds, rest = divmod(nanoseconds, 1_000_000_000)
        return b"".join(
            (
                struct.pack("<3I", self._sequence, seconds, rest),
                self._constant,
                struct.pack("<I", len(ranges)),
                ranges.astype("<f4", copy=False).tobytes(),
                struct.pack("<I", len(intensities)),
                intensities.astype("<f4", copy=False).tobytes(),
            )
        )
