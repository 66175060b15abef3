"""The layers and models as marker arrays, for viewers that connect at any time.

`~debug/layers` and `~debug/walls` have the walls of all layers, `~debug/layer/<name>` and
`~debug/layer/<name>_3d` those of one; `~debug/models` has the markers of all moving models.

For rviz, `~debug/model/<name>` is published at a rate of real time while it has subscribers and the
model moves, for new subscribers, and once a second; it is latched while it has subscribers.
`~debug/topics` is latched and lists the topics of layers and models without `~debug/`.
"""

import time
from functools import partial
from typing import Any, Dict, List, Optional

from flatland_server.hub.wall_visualization import WallVisualization
from flatland_server.messages.message_types import get
from flatland_server.messages.model_markers import ModelMarkers
from flatland_server.messages.serialized_markers import DELETE_ALL, MarkerBytes, array_of
from flatland_server.models.model import Model
from flatland_server.real_time_timer import RealTimeTimer
from flatland_server.simulation.world import World
from flatland_server.transport.served_transport import ServedTransport
from flatland_server.transport.transport import Publisher

DebugTopicList = get("flatland_msgs/DebugTopicList")
MarkerArray = get("visualization_msgs/MarkerArray")

_FULL_PERIOD = 1.0
"""Seconds of real time after which models at rest are published again."""

_AGAIN_DELAYS = (1.0, 3.0)
"""Seconds of real time after a jump of simulated time until walls are published again. rviz
discards all markers, latched ones too, when it notices that time went back: soon after /clock did,
unless the machine is busy."""


class MarkerPublisher:
    """Publishes the markers of a world.

    Args:
        world: the world to show.
        transport: transport on which the topics are published.
        rate: how often models are published [Hz of real time].
        for_rviz: whether each model has a topic, with a list of these topics.
    """

    def __init__(
        self, world: World, transport: ServedTransport, rate: float, *, for_rviz: bool
    ) -> None:
        self._world = world
        self._transport = transport
        self._for_rviz = for_rviz
        self._timer = RealTimeTimer(1.0 / rate)
        self._next_full = 0.0
        self._subscriber_revision: object = None
        self._walls_due: List[float] = []  # when they are published again
        self._walls = WallVisualization(world.layers, partial(self._advertise, latch=True))
        self._models: Dict[str, _ModelDisplay] = {}
        self._closing: List[Publisher] = []  # of deleted models
        self._all = self._advertise("models", MarkerArray, latch=False)
        if for_rviz:
            self._topics = self._advertise("topics", DebugTopicList, latch=True)
        self._follow_models()
        self._publish_topics()

    def update(self) -> None:
        """Publishes the markers that are due. To be called often, on the simulation's thread."""
        if not self._timer.check_update():
            return
        now = time.monotonic()
        while self._walls_due and now >= self._walls_due[0]:
            del self._walls_due[0]
            self._walls.publish_again()
        has_other_layers = self._walls.update(self._world.layers)
        while self._closing:
            self._closing.pop().close()
        has_changed = self._follow_models()
        if has_changed or has_other_layers:
            self._publish_topics()
        # Models at rest are published again for new subscribers only, and once a period.
        revision, before = self._transport.subscriber_revision, self._subscriber_revision
        self._subscriber_revision = revision
        is_full = has_changed or revision != before or now >= self._next_full
        if is_full:
            self._next_full = now + _FULL_PERIOD
        for_all = self._all.has_subscribers
        parts = [DELETE_ALL] if has_changed else []
        for display in self._models.values():
            if (display.has_subscribers() or for_all) and (display.markers.place() or is_full):
                parts.append(display.publish())
        if for_all and parts:
            self._all.publish(array_of(parts))

    def time_has_jumped(self) -> None:
        """Publishes the walls again for viewers that discard all markers when time goes back."""
        now = time.monotonic()
        self._walls_due = [now + delay for delay in _AGAIN_DELAYS]

    def _follow_models(self) -> bool:
        """Adds displays of new models and removes those of deleted ones; returns whether any."""
        present = self._world.models
        gone = [
            name for name, shown in self._models.items() if present.get(name) is not shown.model
        ]
        for name in gone:
            self._closing += self._models.pop(name).end()
        new = [model for name, model in present.items() if name not in self._models]
        for model in new:
            publisher = None
            if self._for_rviz:
                topic, latch = f"model/{model.name}", self._transport.can_forget
                publisher = self._advertise(topic, MarkerArray, latch=latch)
            self._models[model.name] = _ModelDisplay(model, self._transport, publisher)
        return bool(gone or new)

    def _publish_topics(self) -> None:
        if self._for_rviz:
            models = [f"model/{name}" for name in self._models]
            self._topics.publish(DebugTopicList([*self._walls.topics, *models]))

    def _advertise(self, topic: str, message_type: Any, *, latch: bool) -> Publisher:
        name = f"{self._transport.node_name}/debug/{topic}"
        return self._transport.advertise(name, message_type, latch=latch, queue_size=1)


class _ModelDisplay:
    """The markers of a model, and its own topic, if it has one."""

    def __init__(
        self, model: Model, transport: ServedTransport, publisher: Optional[Publisher]
    ) -> None:
        self.model = model
        self._transport = transport
        self.markers = ModelMarkers(model)
        self._publisher = publisher
        self._had_subscribers = False

    def has_subscribers(self) -> bool:
        """True if the model's own topic has subscribers. Without, it keeps no message for later."""
        if self._publisher is None:
            return False
        has_subscribers = self._publisher.has_subscribers
        if self._had_subscribers and not has_subscribers:
            self._transport.forget(self._publisher)
        self._had_subscribers = has_subscribers
        return has_subscribers

    def publish(self) -> MarkerBytes:
        """Returns the markers, and publishes them if the model's own topic has subscribers."""
        markers = self.markers.bytes()
        if self._had_subscribers and self._publisher is not None:
            self._publisher.publish(array_of([markers]))
        return markers

    def end(self) -> List[Publisher]:
        """Makes rviz delete the markers. Returns the publisher, if any, to be closed a while after
        this last message, which may be sent later.
        """
        if self._publisher is None:
            return []
        self._publisher.publish(array_of([DELETE_ALL]))
        self._transport.forget(self._publisher)  # a new model of the same name has the same topic
        return [self._publisher]
