"""Simulated time for the other nodes, and for this one."""

import rospy
from rosgraph_msgs.msg import Clock
from rospy.impl import simtime
from rospy.rostime import _set_rostime

from flatland_server.timekeeper import Timekeeper


class ClockPublisher:
    """Publishes /clock. The ROS node must be initialised.

    With use_sim_time, rospy would hear our clock through a socket to itself; it is told directly.
    """

    def __init__(self, timekeeper: Timekeeper) -> None:
        self._timekeeper = timekeeper
        self._publisher = rospy.Publisher("/clock", Clock, queue_size=100, tcp_nodelay=True)
        self._tell_rospy = simtime._is_use_simtime()
        if self._tell_rospy:
            simtime._clock_sub.unregister()
        self.publish()

    def publish(self) -> None:
        """Announces the time of now."""
        now = rospy.Time(*divmod(self._timekeeper.nanoseconds, 1_000_000_000))
        if self._tell_rospy:
            _set_rostime(now)
        if self._publisher.get_num_connections() > 0:
            self._publisher.publish(now)
