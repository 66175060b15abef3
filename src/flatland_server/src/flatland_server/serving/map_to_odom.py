"""Stands in for a localiser: publishes identity from the map to each odometry frame."""

from typing import Any, Callable, Collection, Set

from flatland_server.messages.message_types import get
from flatland_server.real_time_timer import RealTimeTimer
from flatland_server.transport.static_transforms import TOPIC
from flatland_server.transport.transport import Transport

TransformStamped = get("geometry_msgs/TransformStamped")
TFMessage = get("tf2_msgs/TFMessage")

FRAME_ID = "map"
"""The frame of the world."""

_PERIOD = 0.1  # s of real time


class MapToOdom:
    """Publishes identity from `map` to the odometry frames of all robots.

    Args:
        transport: publishes it.
        odometry_frames: returns the present frames of odometry: robots come and go.
        always: frames that need no robot.
    """

    def __init__(
        self,
        transport: Transport,
        odometry_frames: Callable[[], Collection[str]],
        always: Collection[str] = ("odom",),
    ) -> None:
        self._odometry_frames = odometry_frames
        self._timer = RealTimeTimer(_PERIOD)
        self._publisher = transport.advertise(TOPIC, TFMessage, latch=True, queue_size=10)
        self._published: Set[str] = {FRAME_ID}
        self._publish({*always, *odometry_frames()})

    @property
    def frames(self) -> Set[str]:
        """The frames that were placed in the map."""
        return self._published - {FRAME_ID}

    def update(self) -> None:
        """Publishes if there is a new frame; to be called often."""
        if self._timer.check_update():
            self.publish_new()

    def publish_new(self) -> None:
        """Publishes if there is a new frame."""
        self._publish(self._odometry_frames())

    def _publish(self, frames: Collection[str]) -> None:
        new = set(frames) - self._published
        if new:
            self._published |= new
            self._publisher.publish(TFMessage([_identity(frame) for frame in sorted(new)]))

    def close(self) -> None:
        """Ends the publishing."""
        self._publisher.close()


def _identity(frame: str) -> Any:
    transform = TransformStamped(child_frame_id=frame)
    transform.header.frame_id = FRAME_ID
    transform.transform.rotation.w = 1.0
    return transform
