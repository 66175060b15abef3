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
        """Starts to record; after the last test nothing is kept for the garbage collector."""
        recorder = Recorder(topic, message_type)
        cls.addClassCleanup(recorder.messages.clear)
        cls.addClassCleanup(recorder.close)
        return recorder


def publish_rates(recorders: Sequence[Recorder], seconds: float) -> List[float]:
    """Messages per second of simulated time in the last seconds of topics with headers."""

    def last_stamps(recorder: Recorder) -> Optional[List[int]]:
        stamps = sorted({m.header.stamp.to_nsec() for m in list(recorder.messages)})
        begin = stamps[-1] - round(seconds * 1e9) if stamps else 0
        is_recorded = stamps and stamps[0] <= begin
        return [stamp for stamp in stamps if stamp > begin] if is_recorded else None

    return [
        len(wait_until(lambda r=recorder: last_stamps(r), f"{seconds} s of {recorder.topic}"))
        / seconds
        for recorder in recorders
    ]
