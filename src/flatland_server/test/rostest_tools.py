"""Tools of the rostests: waiting with a limit, and recording messages."""

import time
from typing import Any, Callable, Dict, List, Optional, Type

import rospy

LIMIT = 20.0  # s of real time


def wait_until(holds: Callable[[], Any], what: str, limit: float = LIMIT) -> Any:
    """The first true value of `holds()`; fails with `what` when it takes too long."""
    deadline = time.monotonic() + limit
    while time.monotonic() < deadline:
        value = holds()
        if value:
            return value
        time.sleep(0.005)
    raise AssertionError(f"waited {limit:g} s for {what}")


class Recorder:
    """Records the messages of a topic."""

    def __init__(self, topic: str, message_type: Type[Any]) -> None:
        self.topic = topic
        self.messages: List[Any] = []
        self._subscriber = rospy.Subscriber(topic, message_type, self.messages.append)

    def next(self, count: int = 1, holds: Optional[Callable[[Any], bool]] = None) -> Any:
        """The `count`-th message from now on for which `holds`."""
        begin = len(self.messages)

        def found() -> List[Any]:
            new = [m for m in self.messages[begin:] if holds is None or holds(m)]
            return new[count - 1 : count]

        return wait_until(found, f"message {count} on {self.topic}")[0]

    def close(self) -> None:
        """Unsubscribes."""
        self._subscriber.unregister()


def publish_rate(recorder: Recorder, seconds: float) -> float:
    """Messages per second of simulated time, over a time [s], of a topic with a header."""
    first = recorder.next().header.stamp
    begin = len(recorder.messages)
    last = recorder.next(holds=lambda m: (m.header.stamp - first).to_sec() >= seconds)
    stamps: Dict[int, None] = {m.header.stamp.to_nsec(): None for m in recorder.messages[begin:]}
    count = len([stamp for stamp in stamps if stamp <= last.header.stamp.to_nsec()])
    return count / (last.header.stamp - first).to_sec()
