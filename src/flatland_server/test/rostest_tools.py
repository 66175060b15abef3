"""Tools of the rostests: recording messages, and their rates."""

import unittest
from typing import Any, Callable, List, Optional, Sequence, Type

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
    """Base of tests that record topics until the last of them."""

    @classmethod
    def record(cls, topic: str, message_type: Type[Any]) -> Recorder:
        recorder = Recorder(topic, message_type)
        cls.addClassCleanup(recorder.close)
        return recorder


def publish_rates(recorders: Sequence[Recorder], seconds: float) -> List[float]:
    """Messages per second of simulated time, over the same time [s], of topics with headers."""
    firsts = [recorder.next().header.stamp for recorder in recorders]
    rates = []
    for recorder, first in zip(recorders, firsts):

        def is_over(m: Any, first: Any = first) -> bool:
            return bool((m.header.stamp - first).to_sec() >= seconds)

        wait_until(
            lambda r=recorder, over=is_over: over(r.messages[-1]),
            f"{seconds} s of {recorder.topic}",
        )
        last = next(m.header.stamp for m in recorder.messages if is_over(m))
        stamps = {m.header.stamp.to_nsec() for m in recorder.messages}
        count = len([stamp for stamp in stamps if first.to_nsec() < stamp <= last.to_nsec()])
        rates.append(count / (last - first).to_sec())
    return rates
