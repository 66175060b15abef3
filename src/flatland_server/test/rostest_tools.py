"""Tools of the rostests: recording messages, and their rates."""

import unittest
from functools import reduce
from math import gcd
from typing import Any, Callable, Iterable, List, Optional, Type

import numpy as np
import rospy
from waiting import wait_until


class Recorder:
    """Records the messages of a topic."""

    def __init__(self, topic: str, message_type: Type[Any]) -> None:
        self.topic = topic
        self.messages: List[Any] = []
        self._subscriber = rospy.Subscriber(topic, message_type, self.messages.append)

    def next(self, count: int = 1, holds: Optional[Callable[[Any], bool]] = None) -> Any:
        """The `count`-th message from now on for which `holds`."""
        seen = len(self.messages)
        new: List[Any] = []

        def found() -> List[Any]:
            nonlocal seen
            unseen = self.messages[seen:]
            seen += len(unseen)
            new.extend(m for m in unseen if holds is None or holds(m))
            return new[count - 1 : count]

        return wait_until(found, f"message {count} on {self.topic}")[0]

    def close(self) -> None:
        """Unsubscribes."""
        self._subscriber.unregister()


class RecordingCase(unittest.TestCase):
    """Base of tests that record topics until the last test."""

    @classmethod
    def record(cls, topic: str, message_type: Type[Any]) -> Recorder:
        """Records a topic; the last test's end unsubscribes, and frees the messages."""
        recorder = Recorder(topic, message_type)
        cls.addClassCleanup(recorder.messages.clear)
        cls.addClassCleanup(recorder.close)
        return recorder


def publish_rate(recorder: Recorder, count: int) -> float:
    """Rate of a topic with headers [Hz of simulated time], from its next `count` messages.

    Stamps are whole periods apart, so the result does not change if a subscriber on a busy machine
    loses messages.
    """
    recorder.next(count)
    return 1e9 / period({message.header.stamp.to_nsec() for message in list(recorder.messages)})


def period(times: Iterable[int]) -> int:
    """The longest period of which all times are a number apart [ns]."""
    return reduce(gcd, np.diff(sorted(times)).tolist())
