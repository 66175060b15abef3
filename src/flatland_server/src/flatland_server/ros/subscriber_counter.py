"""Counts the changes of subscribers of rospy's publishers."""

import itertools
from typing import Any

import rospy


class SubscriberCounter(rospy.SubscribeListener):  # type: ignore[misc]
    """Counts how often subscribers have connected or disconnected. ROS's threads call it."""

    def __init__(self) -> None:
        self._counter = itertools.count(1)
        self.revision = 0

    def peer_subscribe(self, *_: Any) -> None:
        self.revision = next(self._counter)

    def peer_unsubscribe(self, *_: Any) -> None:
        self.revision = next(self._counter)
