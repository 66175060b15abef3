"""The markers of all models on one topic, `~debug/models`, for viewers that connect at any time."""

import time
from typing import Dict

from flatland_server.messages.message_types import get
from flatland_server.messages.model_markers import ModelMarkers
from flatland_server.messages.serialized_markers import array_of, delete_all
from flatland_server.models.model import Model
from flatland_server.real_time_timer import RealTimeTimer
from flatland_server.simulation.world import World

MarkerArray = get("visualization_msgs/MarkerArray")

_FULL_PERIOD = 1.0
"""Seconds of real time after which models at rest are published again."""


class ModelMarkerPublisher:
    """Publishes the markers of moving models while they have a subscriber.

    `flatland_server.ros.debug_visualization` does so for ROS, with a topic for each model besides.

    Args:
        world: has the models.
        rate: how often they are published [Hz of real time].
        frame_id: of the world.
    """

    def __init__(self, world: World, rate: float, frame_id: str) -> None:
        self._world = world
        self._frame_id = frame_id
        self._timer = RealTimeTimer(1.0 / rate)
        self._next_full = 0.0
        self._subscriber_revision: object = None
        self._shown: Dict[Model, ModelMarkers] = {}
        self._publisher = world.transport.advertise(
            f"{world.transport.node_name}/debug/models", MarkerArray, latch=False, queue_size=1
        )

    def update(self) -> None:
        """Publishes the markers that are due. To be called often, on the simulation's thread."""
        if not (self._publisher.has_subscribers and self._timer.check_update()):
            return
        models = self._world.models.values()
        parts = []
        if list(models) != list(self._shown):
            self._shown = {model: ModelMarkers(model, self._frame_id) for model in models}
            self._next_full = 0.0
            parts.append(delete_all(self._frame_id))
        now, revision = time.monotonic(), self._world.transport.subscriber_revision
        is_full = now >= self._next_full or revision != self._subscriber_revision
        self._subscriber_revision = revision
        if is_full:
            self._next_full = now + _FULL_PERIOD
        parts += [each.bytes() for each in self._shown.values() if each.place() or is_full]
        if parts:
            self._publisher.publish(array_of(parts))
