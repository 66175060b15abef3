"""Stands in for a localiser: publishes identity from the map to each odometry frame."""

from typing import Any, Set

from flatland_server.messages.message_types import get
from flatland_server.real_time_timer import RealTimeTimer
from flatland_server.simulation.world import World

TFMessage = get("tf2_msgs/TFMessage")
TransformStamped = get("geometry_msgs/TransformStamped")

FRAME_ID = "map"
"""The frame of the world."""

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
        self._publisher = world.transport.advertise(
            "/tf_static", TFMessage, latch=True, queue_size=10
        )
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


def _identity(frame: str) -> Any:
    transform = TransformStamped(child_frame_id=frame)
    transform.header.frame_id = FRAME_ID
    transform.transform.rotation.w = 1.0
    return transform
