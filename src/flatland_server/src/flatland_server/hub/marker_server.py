"""The topics of interactive markers, as rviz's display of them reads them.

`update` has the changes, each with a number; `update_full` is latched, and has all markers as of
a number, from which a new display follows the changes. Without any message for a second, a display
takes the server to be gone.
"""

from copy import copy
from typing import Any, Callable, Dict, List

from flatland_server.messages.message_types import get
from flatland_server.transport.transport import Transport

Feedback = get("visualization_msgs/InteractiveMarkerFeedback")
Init = get("visualization_msgs/InteractiveMarkerInit")
MarkerPose = get("visualization_msgs/InteractiveMarkerPose")
Update = get("visualization_msgs/InteractiveMarkerUpdate")

_QUEUE_SIZE = 100


class MarkerServer:
    """Publishes interactive markers.

    Args:
        transport: transport on which the topics are published.
        name: prefix of the topics' names, before `/update` and the others.
        on_feedback: called with each message of a display, between two steps.
    """

    def __init__(self, transport: Transport, name: str, on_feedback: Callable[[Any], None]) -> None:
        self._id = transport.node_name
        self._markers: Dict[str, Any] = {}
        self._changed: Dict[str, Any] = {}  # markers to send whole
        self._moved: Dict[str, Any] = {}
        self._erased: List[str] = []
        self._number = 0
        self._full = transport.advertise(
            f"{name}/update_full", Init, latch=True, queue_size=_QUEUE_SIZE
        )
        self._updates = transport.advertise(
            f"{name}/update", Update, latch=False, queue_size=_QUEUE_SIZE
        )
        transport.subscribe(f"{name}/feedback", Feedback, on_feedback)
        self._publish_all()

    @property
    def has_subscribers(self) -> bool:
        """True if there is a display."""
        return self._updates.has_subscribers

    def insert(self, marker: Any) -> None:
        """Adds a marker, in place of one of the same name; `send` sends it.

        Args:
            marker: a visualization_msgs/InteractiveMarker.
        """
        self._markers[marker.name] = self._changed[marker.name] = marker

    def erase(self, name: str) -> None:
        """Removes a marker."""
        for markers in (self._markers, self._changed, self._moved):
            markers.pop(name, None)
        self._erased.append(name)

    def move(self, name: str, pose: Any) -> None:
        """Moves a marker.

        Args:
            name: the marker's name.
            pose: a geometry_msgs/Pose.
        """
        marker = self._markers[name] = copy(self._markers[name])  # that of messages stays
        marker.pose = pose
        self._moved[name] = MarkerPose(marker.header, pose, name)

    def send(self) -> None:
        """Sends all changes."""
        self._number += 1
        # A display inserts first: it would erase a marker that replaces one of its name.
        erased = [name for name in self._erased if name not in self._markers]
        self._publish(Update.UPDATE, [*self._changed.values()], [*self._moved.values()], erased)
        self._changed.clear()
        self._moved.clear()
        self._erased.clear()
        self._publish_all()

    def keep_alive(self) -> None:
        """Tells displays that the markers are still there."""
        self._publish(Update.KEEP_ALIVE, [], [], [])

    def _publish(self, kind: int, *changes: List[Any]) -> None:
        self._updates.publish(Update(self._id, self._number, kind, *changes))

    def _publish_all(self) -> None:
        self._full.publish(Init(self._id, self._number, list(self._markers.values())))
