"""Tools of the rostests: waiting with a limit, and recording messages."""

import time
from typing import Any, Callable, List, Optional, Sequence, Type

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
