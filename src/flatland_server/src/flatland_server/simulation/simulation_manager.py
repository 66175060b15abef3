"""Runs a world in real time, faster or slower, and pauses it."""

import logging
import math
import time
from concurrent.futures import Future
from typing import Callable, List, Optional, Sequence

from flatland_server.exceptions import FlatlandError, UsageError, suggestion
from flatland_server.simulation.history import RunWithHistory
from flatland_server.simulation.pacer import Pacer, WallPacer, WallTimekeeper
from flatland_server.simulation.world import World
from flatland_server.timekeeper import Timekeeper
from flatland_server.transport.arrivals import Arrivals

logger = logging.getLogger(__name__)

_PATIENCE = 1.0
"""Real time after which a controller without a command is no longer waited for [s]."""

_COMMAND_WAIT = 0.001
"""Real time between two looks for a command that is waited for [s]."""


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


class CommandWait:
    """Tells when the simulation is to wait, since a controller's last command is too old.

    A controller is waited for from its first command on. One that sends none for a second of real
    time has ended or has no goal: it is waited for again from its next command on.

    Args:
        arrivals: arrivals of messages on the transport.
        steps: the age of a command from which on the simulation waits for the next one.
        clock: returns the real time [s].
    """

    def __init__(self, arrivals: Arrivals, steps: int, clock: Callable[[], float]) -> None:
        self._arrivals = arrivals
        self._steps = steps
        self._clock = clock
        self._since: Optional[float] = None

    def is_due(self, is_stepping: bool) -> bool:
        """True if the next step has to wait.

        Args:
            is_stepping: whether steps are made at all; during a pause, no controller is late.
        """
        newest = self._arrivals.step - self._steps
        late = [each for each in self._arrivals.commands if 0 <= each.step <= newest]
        if not late or not is_stepping:
            self._since = None
            return False
        now = self._clock()
        if self._since is None:
            self._since = now
        if now - self._since < _PATIENCE:
            return True
        for each in late:
            logger.info("no command on %s for %g s: not waited for", each.topic, _PATIENCE)
            each.forget()
        return False


class SimulationManager(RunWithHistory):
    """Steps a world at a rate of real time, and runs the callbacks of subscriptions in between.

    Args:
        world: world to step.
        timekeeper: counts the simulated time; a `WallTimekeeper` allows no rate but real time.
        update_rate: steps per second of real time; infinity is as fast as the machine can.
        command_age: simulated time after a command from which on time stands still until the next
            one comes [s]; see `CommandWait`. Infinity: never.
        clock: returns the real time [s].

    Raises:
        ValueError: the rate is not above zero, or not that of real time though stamps are.
    """

    def __init__(
        self,
        world: World,
        timekeeper: Timekeeper,
        update_rate: float = 200.0,
        *,
        command_age: float = math.inf,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        if not update_rate > 0:
            raise ValueError(f"expected an update rate above 0 Hz, found {update_rate}")
        super().__init__(world, timekeeper)
        self.pacer = Pacer(clock)
        """Says when steps are due, and how late they were."""
        if isinstance(timekeeper, WallTimekeeper):
            self.pacer = WallPacer(timekeeper, clock)
        self.change_rate(update_rate * timekeeper.step_size)
        self.is_paused = False
        self.is_held = False
        """True if time stands still for a while, as when a model is dragged. Does not affect
        `is_paused`; no steps can be requested unless that is set, too."""
        self.on_tick: List[Callable[[], None]] = []
        """Called before each wait for the next step, and otherwise every millisecond; also during
        a pause."""
        self._clock = clock
        self._command_wait: Optional[CommandWait] = None
        if math.isfinite(command_age):
            steps = max(1, round(command_age / timekeeper.step_size))
            self._command_wait = CommandWait(world.transport.arrivals, steps, clock)
        self.after_jump.append(lambda: self.pacer.start(self.timekeeper.seconds))
        self._request: Optional[StepRequest] = None

    @property
    def rate(self) -> float:
        """The requested simulated seconds per second of real time; may be infinite."""
        return self.update_rate * self.timekeeper.step_size

    def change_rate(self, rate: float) -> None:
        """Requests another `rate`: 1 is real time, infinity as fast as the machine can.

        Args:
            rate: simulated seconds per second of real time: 1 is real time, infinity as fast as the
                machine can.

        Raises:
            ValueError: the rate is not above zero, or not 1 though stamps are of real time.
        """
        if not rate > 0:
            raise ValueError(f"expected a rate above 0, found {rate}")
        if isinstance(self.pacer, WallPacer) and not math.isclose(rate, 1.0, rel_tol=1e-6):
            raise UsageError(
                f"expected a rate of 1, since messages are stamped with real time, found {rate:g}"
            )
        self.update_rate = rate / self.timekeeper.step_size

    def pause(self) -> None:
        """Makes `run` stop making steps, also those that were requested; callbacks go on."""
        self.is_paused = True
        if self._request is not None:
            self._request.fail("the simulation was paused before the steps were made")

    def resume(self) -> None:
        """Ends a pause."""
        self.is_paused = False

    @property
    def is_stepping(self) -> bool:
        """True if `run` makes steps on its own: it is neither paused nor held."""
        return not (self.is_paused or self.is_held)

    def toggle_pause(self) -> None:
        """Pauses or resumes."""
        self.is_paused = not self.is_paused

    def request_steps(
        self, count: int = 1, expected: Sequence[str] = (), timeout: float = 10.0
    ) -> "Future[int]":
        """Makes `run` make steps during a pause, one after the other without waits.

        Args:
            count: number of steps.
            expected: topics, by their absolute names. The first step waits until a message has come
                on each of them since the last step.
            timeout: how long it waits for them [s of real time].

        Returns:
            A future of the simulated time at which the last step has ended [ns]. It raises a
            FlatlandError if a message does not come in time, the simulation is paused once more or
            resumed before the steps are made, or ends.

        Raises:
            ValueError: the count is below 1, the timeout is not above 0, or a topic has no
                subscription here.
            FlatlandError: the simulation is not paused, or makes the steps of another request.
        """
        if not timeout > 0.0:
            raise ValueError(f"expected a timeout above 0 s, found {timeout}")
        if self._request is not None:
            raise FlatlandError("the steps of another request are being made")
        if not self.is_paused:
            raise FlatlandError("the simulation is not paused")
        return self._begin(count, expected, timeout).done

    def advance(self, count: int, *, then_pause: bool) -> "Future[int]":
        """Makes `run` make steps, paused or not, one after the other without waits.

        Args:
            count: number of steps; they follow those of a request that is being served.
            then_pause: whether the simulation is paused after them; else it is as before.

        Returns:
            A future as of `request_steps`.
        """
        if self._request is not None:
            self._request.extend(count)
            return self._request.done
        request = self._begin(count)
        request.resumes = not (self.is_paused or then_pause)
        self.is_paused = True
        return request.done

    def _begin(
        self, count: int, expected: Sequence[str] = (), timeout: float = math.inf
    ) -> StepRequest:
        deadline = self._clock() + timeout
        self._request = StepRequest(count, expected, deadline, self.transport.arrivals)
        self.transport.returns_on_arrival = True
        return self._request

    def run(self, goes_on: Callable[[], bool]) -> None:
        """Runs in real time until `goes_on()`, which is called before each step, is false.

        Args:
            goes_on: called before each step; the run ends when it returns False.
        """
        pacer, transport = self.pacer, self.transport
        pacer.start(self.timekeeper.seconds)
        is_hurrying = ends_request = False  # is making the steps of a request; has made the last
        is_late = False  # the controllers are
        try:
            while True:
                wait_time = 0.0 if is_hurrying else pacer.wait_time
                if is_late:
                    wait_time = max(wait_time, _COMMAND_WAIT)
                transport.process(wait_time)
                if not goes_on():
                    return
                if self._command_wait is not None:
                    is_late = self._command_wait.is_due(self.is_stepping)
                is_due = pacer.begin_step(self.is_paused or self.is_held)
                if is_due and is_late:
                    pacer.skip_step()
                    is_due = False
                if self._request is not None:
                    is_hurrying = self._serve(self._request)
                    ends_request = self._request.is_complete
                if is_due and not is_hurrying:
                    self._step()
                if is_hurrying:
                    is_tick_due = pacer.end_step(0.0, is_paused=False)
                else:
                    is_paused = self.is_paused or self.is_held
                    is_tick_due = pacer.end_step(1.0 / self.update_rate, is_paused)
                if is_tick_due or ends_request:
                    for callback in self.on_tick:
                        callback()
                    pacer.end_tick(self.timekeeper.seconds)
                if ends_request:
                    transport.release()
                    self._end_request()
                    ends_request = False
        finally:
            transport.release()
            if self._request is not None:
                self._request.fail("the simulation has ended")
                self._end_request()

    def _serve(self, request: StepRequest) -> bool:
        """Makes a step of a request if one is due. Returns whether another one may follow now."""
        if not self.is_paused:
            request.fail("the simulation was resumed before the steps were made")
        elif request.is_step_due(self._clock()):
            self._step()
            request.step_made()
            return not request.is_complete
        return False

    def _end_request(self) -> None:
        """Reports the end of a request; the last tick has sent all messages of its steps."""
        request, self._request = self._request, None
        self.transport.returns_on_arrival = False
        if request is not None:
            if request.resumes and not request.done.done():
                self.resume()
            request.finish(self.timekeeper.nanoseconds)

    def _step(self) -> None:
        self._step_up_to(1)
        for callback in self.after_step:
            callback()
