"""Rates and last messages of a few topics, while a panel shows them."""

import threading
from collections import deque
from typing import Any, Deque, Dict, List, NamedTuple, Optional, Tuple

import roslib.message
import rospy

from flatland_viz.model_list import Topic
from flatland_viz.topic_values import describe, is_described

_WINDOW = 2.0  # s of simulated time, in which messages are counted


class Reading(NamedTuple):
    """The rate and the last message of a topic."""

    rate: Optional[float]
    """Messages per second of simulated time; None if it is not known yet."""
    value: str
    """The last message in a few words; empty if there was none."""


class TopicMonitor:
    """Subscribes to topics from `watch` until the next `watch` or `close`."""

    def __init__(self) -> None:
        self._watched: Dict[str, _Watched] = {}

    def watch(self, topics: List[Topic]) -> None:
        """Subscribes to these topics, and to no others."""
        wanted = {topic.name: topic.type for topic in topics}
        others = [name for name, each in self._watched.items() if wanted.get(name) != each.type]
        for name in others:
            self._watched.pop(name).close()
        for name, kind in wanted.items():
            if name not in self._watched:
                self._watched[name] = _Watched(name, kind)

    def readings(self, time: float) -> Dict[str, Reading]:
        """The readings of all topics, by name.

        Args:
            time: the present simulated time [s].
        """
        return {name: watched.reading(time) for name, watched in self._watched.items()}

    def close(self) -> None:
        """Unsubscribes from all topics."""
        self.watch([])


class _Watched:
    def __init__(self, name: str, kind: str) -> None:
        self.type = kind
        self._lock = threading.Lock()  # rospy calls back on threads of its own
        self._count = 0
        self._last: Any = None
        self._value = ""
        self._counts: Deque[Tuple[float, int]] = deque()  # simulated time, messages until then
        # rospy's subscribers of a topic share the first one's class, the trail's among them. Other
        # types are not looked up: the server has said their names, and that imports packages.
        message_class = roslib.message.get_message_class(kind) if is_described(kind) else None
        self._subscriber = rospy.Subscriber(
            name, message_class or rospy.AnyMsg, self._receive, queue_size=10, buff_size=2**20
        )

    def _receive(self, message: Any) -> None:
        with self._lock:
            self._count += 1
            self._last = message

    def reading(self, time: float) -> Reading:
        with self._lock:
            count, last, self._last = self._count, self._last, None
        if last is not None:
            self._value = describe(self.type, last)
        counts = self._counts
        if counts and time < counts[-1][0]:
            counts.clear()  # the simulation has begun again
        if not counts or time > counts[-1][0]:
            counts.append((time, count))
        while len(counts) > 2 and counts[1][0] <= time - _WINDOW:
            counts.popleft()
        span = counts[-1][0] - counts[0][0]
        rate = (counts[-1][1] - counts[0][1]) / span if span > 0.5 else None
        return Reading(rate, self._value)

    def close(self) -> None:
        self._subscriber.unregister()
