"""Simulated time for the other nodes, and for this one."""

import struct
from typing import List

import rospy
from rosgraph_msgs.msg import Clock
from rospy import rostime
from rospy.impl import simtime

from flatland_server.ros.rospy_patches.nonblocking_connection import send_framed
from flatland_server.timekeeper import Timekeeper

_TICK = struct.Struct("<III")  # the length of the rest, seconds, nanoseconds

_MOST_TICKS = 50
"""That leave together: a listener whose queue holds 100 loses none."""


class ClockPublisher:
    """Publishes /clock. The ROS node must be initialised.

    To send a tick can take longer than to simulate the step. So ticks are gathered, and those of a
    moment leave together; each is a message of its own.

    With use_sim_time, rospy would hear our clock through a socket to itself; it is told directly.
    """

    def __init__(self, timekeeper: Timekeeper) -> None:
        self._timekeeper = timekeeper
        self._publisher = rospy.Publisher("/clock", Clock, queue_size=100, tcp_nodelay=True)
        self._ticks: List[bytes] = []
        self._tell_rospy = simtime._is_use_simtime()
        if self._tell_rospy:
            simtime._clock_sub.unregister()
        self.tick()
        self.flush()

    def tick(self) -> None:
        """Takes note of the time of now. To be called after each step."""
        seconds, nanoseconds = divmod(self._timekeeper.nanoseconds, 1_000_000_000)
        self._ticks.append(_TICK.pack(8, seconds, nanoseconds))
        if self._tell_rospy:
            now = rospy.Time.__new__(rospy.Time)  # its __init__ takes longer than all of this
            now.secs, now.nsecs = seconds, nanoseconds
            rostime._rostime_current = now
        if len(self._ticks) == _MOST_TICKS:
            self.flush()

    def flush(self) -> None:
        """Sends what has been noted, and wakes the threads of this process that wait for a time.

        To be called often, and before anything else is sent: nobody is to hear of a time that his
        clock has not been told.
        """
        if not self._ticks:
            return
        send_framed(self._publisher, b"".join(self._ticks))
        self._ticks.clear()
        if self._tell_rospy:
            condition = rostime.get_rostime_cond()
            with condition:
                condition.notify_all()
