"""/clock over ROS: simulated time for other nodes, and for this process."""

import struct
from typing import List

import rospy
from rosgraph_msgs.msg import Clock as ClockMessage

from flatland_server.exceptions import listed
from flatland_server.ros.rospy_patches import RospyCalls
from flatland_server.ros.rospy_patches.rospy_calls import SubscriberCounter
from flatland_server.timekeeper import Timekeeper
from flatland_server.transport.served_transport import Clock

_TICK_SIZE = 8  # bytes: seconds, nanoseconds

_MAX_NUMBERS = 3 * 50
"""Numbers in 50 ticks, which are sent together: a subscriber with a queue of 100 loses none."""


def warn_of_other_times() -> None:
    """Logs a warning if other nodes use another time than the stamps of this one."""
    if not rospy.get_param("/use_sim_time", False):
        rospy.logwarn(
            "/use_sim_time is not set: other nodes go by real time, though stamps are simulated "
            "time; server.launch sets it, or `rosparam set /use_sim_time true` before nodes start"
        )
    topic = rospy.resolve_name("/clock")
    _, _, (publishers, _, _) = rospy.get_master().getSystemState()
    nodes = {node for name, nodes in publishers if name == topic for node in nodes}
    others = sorted(nodes - {rospy.get_name()})
    if others:
        rospy.logwarn(
            "%s is also published by %s: time will jump from one to the other and back. For a "
            'server in a namespace, remap it: <remap from="/clock" to="clock"/>, and likewise /tf '
            "and /tf_static",
            topic,
            listed(others),
        )


class ClockPublisher(Clock):
    """Publishes /clock. The ROS node must be initialised.

    Sending a tick can take longer than simulating a step. So ticks are collected and sent together,
    each as a message of its own.
    """

    def __init__(self, timekeeper: Timekeeper, rospy_calls: RospyCalls) -> None:
        self._timekeeper = timekeeper
        self._send_framed = rospy_calls.send_framed
        self._subscribers = SubscriberCounter()
        self._publisher = rospy.Publisher(
            "/clock", ClockMessage, self._subscribers, queue_size=100, tcp_nodelay=True
        )
        self._numbers: List[int] = []  # of each tick: size, seconds, nanoseconds
        self._local_time = rospy_calls.take_over_time()
        self._set_local_time = self._local_time.set if self._local_time is not None else None
        self.tick()
        self.flush()

    @property
    def _revision(self) -> object:
        return self._subscribers.revision

    def tick(self) -> None:
        seconds, nanoseconds = divmod(self._timekeeper.nanoseconds, 1_000_000_000)
        numbers = self._numbers
        numbers += (_TICK_SIZE, seconds, nanoseconds)
        if self._set_local_time is not None:
            self._set_local_time(seconds, nanoseconds)
        if len(numbers) == _MAX_NUMBERS:
            self.flush()

    def flush(self) -> None:
        """Sends the collected ticks, and wakes the threads of this process that wait for a time.

        Also to be called before anything else is sent: no stamp may precede its /clock tick.
        """
        numbers = self._numbers
        if not numbers:
            return
        self._served_revision = self._revision
        self._send_framed(self._publisher, struct.pack(f"<{len(numbers)}I", *numbers))
        numbers.clear()
        if self._local_time is not None:
            self._local_time.notify()
