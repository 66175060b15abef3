"""Stands in for a localiser: publishes identity from the map to each odometry frame."""

from typing import Set

import rospy
from geometry_msgs.msg import TransformStamped
from tf2_msgs.msg import TFMessage

from flatland_server.real_time_timer import RealTimeTimer
from flatland_server.ros.debug_visualization import FRAME_ID
from flatland_server.simulation.world import World

_PERIOD = 0.1  # s of real time
_ALWAYS = "odom"


class MapToOdom:
    """Publishes identity from `map` to `odom`, and to the odometry frames of all robots.

    Args:
        world: the world, in which robots come and go.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        self._timer = RealTimeTimer(_PERIOD)
        self._publisher = rospy.Publisher("/tf_static", TFMessage, queue_size=10, latch=True)
        self._published: Set[str] = set()
        self._publish()

    def update(self) -> None:
        """Publishes if there is a new frame; to be called often."""
        if self._timer.check_update():
            self._publish()

    def _publish(self) -> None:
        # All of them each time: a later subscriber gets the last message only.
        frames = (self._published | self._world.odometry_frames | {_ALWAYS}) - {FRAME_ID}
        if frames != self._published:
            self._published = frames
            self._publisher.publish(TFMessage([_identity(frame) for frame in sorted(frames)]))


def _identity(frame: str) -> TransformStamped:
    transform = TransformStamped(child_frame_id=frame)
    transform.header.frame_id = FRAME_ID
    transform.transform.rotation.w = 1.0
    return transform
