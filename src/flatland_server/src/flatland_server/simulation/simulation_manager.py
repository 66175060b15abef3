"""Runs a world in real time, faster or slower, and pauses it."""

import math
import time
from concurrent.futures import Future
from typing import Callable, List, Optional, Sequence

from flatland_server.exceptions import FlatlandError, UsageError
from flatland_server.simulation.command_wait import CommandWait
from flatland_server.simulation.history import RunWithHistory
from flatland_server.simulation.pacer import Pacer
from flatland_server.simulation.step_request import StepRequest
from flatland_server.simulation.wall_timekeeper import WallPacer, WallTimekeeper
from flatland_server.simulation.world import World
from flatland_server.timekeeper import Timekeeper

_COMMAND_WAIT = 0.001
"""Real time between two looks for a command that is waited for [s]."""


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
