#!/usr/bin/python3
"""A scan's transform, from the laser to odom at the scan's stamp, is there when the scan is used.

As a rostest it runs for some seconds, at real time and at five times real time. As a program it
measures a running server for the given time, and prints the results:

    PYTHONPATH="$PYTHONPATH:$(rospack find flatland_server)/test" \
        "$(rospack find flatland_navigation)/test/stamps_rostest.py" --seconds 60
"""

import argparse
import queue
import sys
import time
import unittest
from typing import List, NamedTuple, Optional

import numpy as np
import rospy
import tf2_ros
from flatland_msgs.srv import ChangeRate
from sensor_msgs.msg import LaserScan
from service_calls import call
from waiting import wait_until

LIMIT = 0.05  # s of real time that a lookup may wait
BUSY_LIMIT = 20.0  # s: for a machine that runs other tests too; a later transform counts as lost
FACTORS = (1.0, 5.0)  # times real time


class Found(NamedTuple):
    """Results of lookups: the waiting time of each [s of real time]; NaN if it failed."""

    factor: float
    waits: List[float]
    scans_per_second: float

    @property
    def failures(self) -> int:
        return int(np.isnan(self.waits).sum())

    def __str__(self) -> str:
        waits = 1e3 * np.array(self.waits)
        return (
            f"{self.factor:g} times real time: {len(waits)} scans, "
            f"{self.scans_per_second:.1f} a second, {self.failures} lookups failed; waited "
            f"{np.nanmedian(waits):.2f} ms (median), {np.nanpercentile(waits, 99):.2f} ms (99 %), "
            f"{np.nanmax(waits):.2f} ms (longest)"
        )


class Lookups:
    """Looks up the transform of each scan, at its stamp."""

    def __init__(self) -> None:
        self._buffer = tf2_ros.Buffer()
        self._listener = tf2_ros.TransformListener(self._buffer, tcp_nodelay=True)
        self._scans: queue.Queue[LaserScan] = queue.Queue()
        self._subscriber: Optional[rospy.Subscriber] = None

    def run(self, factor: float, seconds: float, limit: float) -> Found:
        """Looks for some seconds of real time, at a rate; see `_lookup` for the limit."""
        assert call("/change_rate", ChangeRate, factor).success
        self._subscriber = rospy.Subscriber("/scan", LaserScan, self._scans.put, tcp_nodelay=True)
        try:
            # Scans before the first transforms and at another rate do not count.
            wait_until(lambda: self._is_known(self._scans.get(timeout=10.0)), "transforms")
            self._drop(0.5)
            begin = time.monotonic()
            waits = []
            while time.monotonic() - begin < seconds:
                waits.append(self._lookup(self._scans.get(timeout=10.0), limit))
            return Found(factor, waits, len(waits) / (time.monotonic() - begin))
        finally:
            self._subscriber.unregister()
            self._drop(0.0)

    def _drop(self, seconds: float) -> None:
        """Drops the scans of some time."""
        end = time.monotonic() + seconds
        while time.monotonic() < end or not self._scans.empty():
            self._scans.get(timeout=10.0)

    def _is_known(self, scan: LaserScan) -> bool:
        return bool(
            self._buffer.can_transform_core("odom", scan.header.frame_id, scan.header.stamp)[0]
        )

    def _lookup(self, scan: LaserScan, limit: float) -> float:
        """Waiting time of a lookup [s]; NaN if it exceeds the limit."""
        begin = time.monotonic()
        while not self._is_known(scan):
            if time.monotonic() - begin > limit:
                return float("nan")
            time.sleep(0.0005)
        return time.monotonic() - begin


class Stamps(unittest.TestCase):
    def test_no_lookup_fails(self):
        lookups = Lookups()
        for factor in FACTORS:
            found = lookups.run(factor, 3.0, BUSY_LIMIT)
            self.assertEqual(found.failures, 0, str(found))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, required=True, help="of real time, at each rate")
    parser.add_argument("--factors", type=float, nargs="+", default=FACTORS)
    arguments = parser.parse_args(rospy.myargv()[1:])
    rospy.init_node("stamps", disable_rostime=True)
    lookups = Lookups()
    results = [lookups.run(factor, arguments.seconds, LIMIT) for factor in arguments.factors]
    call("/change_rate", ChangeRate, 1.0)
    for found in results:
        print(found)
    return 1 if any(found.failures for found in results) else 0


if __name__ == "__main__":
    if "--seconds" in sys.argv:
        sys.exit(main())
    import rostest

    rospy.init_node("stamps_rostest", disable_rostime=True)
    rostest.rosrun("flatland_navigation", "stamps", "__main__", sys.argv)
