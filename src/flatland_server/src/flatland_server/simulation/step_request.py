"""A request to make some steps during a pause."""

from concurrent.futures import Future
from typing import Sequence

from flatland_server.exceptions import FlatlandError, suggestion
from flatland_server.transport.arrivals import Arrivals


class StepRequest:
    """Steps to be made, the first of them once expected messages have arrived.

    Args:
        count: number of steps, 1 or more.
        expected: topics, by their absolute names; the first step waits until all subscriptions to
            them have received a message since the last step.
        deadline: real time at which the wait ends without a step [s].
        arrivals: arrivals of messages on the transport.

    Raises:
        ValueError: the count is below 1, or a topic has no subscription here.
    """

    def __init__(
        self, count: int, expected: Sequence[str], deadline: float, arrivals: Arrivals
    ) -> None:
        if count < 1:
            raise ValueError(f"expected 1 step or more, found {count}")
        for topic in expected:
            if arrivals.has_received(topic) is None:
                hint = suggestion(topic, arrivals.topics)
                raise ValueError(f"nothing in the simulation subscribes to {topic}{hint}")
        self.done: Future[int] = Future()
        """The simulated time after the last step [ns], or the exception that ended the request."""
        self.resumes = False
        """Whether the pause ends once the steps are made."""
        self._left = count
        self._has_begun = False
        self._expected = expected
        self._deadline = deadline
        self._arrivals = arrivals

    def is_step_due(self, now: float) -> bool:
        """True if a step is due now; ends the request if the wait for messages takes too long.

        Args:
            now: real time [s].
        """
        if not self._has_begun:
            missing = [topic for topic in self._expected if not self._arrivals.has_received(topic)]
            if missing and now < self._deadline:
                return False
            if missing:
                self.fail(f"no message has come on {', '.join(missing)} since the last step")
                return False
            self._has_begun = True
        return not self.done.done()

    def extend(self, count: int) -> None:
        """Adds steps that follow those that are left."""
        self._left += count

    def step_made(self) -> None:
        """Counts a step that was made."""
        self._left -= 1

    @property
    def is_complete(self) -> bool:
        """True if all steps are made, or the request has failed."""
        return self._left == 0 or self.done.done()

    def fail(self, reason: str) -> None:
        """Ends the request with a FlatlandError."""
        if not self.done.done():
            self.done.set_exception(FlatlandError(reason))

    def finish(self, nanoseconds: int) -> None:
        """Reports that all steps are made, at this simulated time."""
        if not self.done.done():
            self.done.set_result(nanoseconds)
