"""Stands in for a localiser: publishes identity from the map to each odometry frame."""

from itertools import groupby
from typing import Any, Callable, Collection, Dict, Set

from flatland_server.config.ros_names import tf_topics
from flatland_server.messages.conversions import FRAME_ID, header
from flatland_server.messages.message_types import get
from flatland_server.real_time_timer import RealTimeTimer
from flatland_server.transport.claims import OdometryFrame
from flatland_server.transport.transport import Publisher, Transport

TransformStamped = get("geometry_msgs/TransformStamped")
TFMessage = get("tf2_msgs/TFMessage")

_PERIOD = 0.1  # s of real time


class MapToOdom:
    """Publishes identity from `map` to the odometry frames of all robots.

    Args:
        transport: transport on which the transforms are sent.
        odometry_frames: returns the present frames of odometry, each with the namespace of its
            transforms: robots come and go.
        always: odometry frames that are published without a robot, too.
    """

    def __init__(
        self,
        transport: Transport,
        odometry_frames: Callable[[], Collection[OdometryFrame]],
        always: Collection[OdometryFrame] = (("", "odom"),),
    ) -> None:
        self._odometry_frames = odometry_frames
        self._timer = RealTimeTimer(_PERIOD)
        self._transport = transport
        self._publishers: Dict[str, Publisher] = {}  # by namespace
        self._published: Set[OdometryFrame] = set()
        self._publish({*always, *odometry_frames()})

    @property
    def frames(self) -> Set[OdometryFrame]:
        """The frames that were placed in the map."""
        return set(self._published)

    def update(self) -> None:
        """Publishes if there is a new frame; to be called often."""
        if self._timer.check_update():
            self.publish_new()

    def publish_new(self) -> None:
        """Publishes if there is a new frame."""
        self._publish(self._odometry_frames())

    def _publish(self, frames: Collection[OdometryFrame]) -> None:
        new = {each for each in frames if each[1] != FRAME_ID} - self._published
        self._published |= new
        for namespace, group in groupby(sorted(new), lambda each: each[0]):
            self._publisher(namespace).publish(TFMessage([_identity(frame) for _, frame in group]))

    def _publisher(self, namespace: str) -> Publisher:
        if namespace not in self._publishers:
            _, topic = tf_topics(namespace)
            self._publishers[namespace] = self._transport.advertise(
                topic, TFMessage, latch=True, queue_size=10
            )
        return self._publishers[namespace]

    def close(self) -> None:
        """Ends the publishing."""
        for publisher in self._publishers.values():
            publisher.close()


def _identity(frame: str) -> Any:
    transform = TransformStamped(header=header(0, FRAME_ID), child_frame_id=frame)
    transform.transform.rotation.w = 1.0
    return transform
