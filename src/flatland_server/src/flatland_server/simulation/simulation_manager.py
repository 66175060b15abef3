"""Runs a world in real time, faster or slower, and pauses it."""

import time
from typing import Callable, List

from flatland_server._deprecated import renamed
from flatland_server.simulation.pacer import Pacer
from flatland_server.simulation.world import World
from flatland_server.timekeeper import Timekeeper


class SimulationManager:
    """Steps a world at a rate of real time, and runs the callbacks of subscriptions in between.

    Args:
        world: what is stepped.
        timekeeper: counts the simulated time.
        update_rate: steps per second of real time; infinity is as fast as the machine can.
        clock: returns the real time [s].

    Raises:
        ValueError: the rate is not above zero.
    """

    def __init__(
        self,
        world: World,
        timekeeper: Timekeeper,
        update_rate: float = 200.0,
        *,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        if not update_rate > 0:
            raise ValueError(f"expected an update rate above 0 Hz, found {update_rate}")
        self.world = world
        self.timekeeper = timekeeper
        self.change_rate(update_rate * timekeeper.step_size)
        self.is_paused = False
        self.after_step: List[Callable[[], None]] = []
        """Called after each step."""
        self.on_tick: List[Callable[[], None]] = []
        """Called before each wait for the next step, and otherwise every millisecond; also during
        a pause."""
        self._pacer = Pacer(clock)

    each_turn = renamed("each_turn", "on_tick")

    @property
    def rate(self) -> float:
        """The requested simulated seconds per second of real time; may be infinite."""
        return self.update_rate * self.timekeeper.step_size

    @property
    def real_time_factor(self) -> float:
        """The measured simulated seconds per second of real time, in the last second of `run`."""
        return self._pacer.real_time_factor

    @property
    def step_periods(self) -> List[float]:
        """Real time from the start of each of the latest steps to the next, since a pause [s]."""
        return self._pacer.step_periods

    def change_rate(self, rate: float) -> None:
        """Requests another `rate`: 1 is real time, infinity as fast as the machine can.

        Raises:
            ValueError: the rate is not above zero.
        """
        if not rate > 0:
            raise ValueError(f"expected a rate above 0, found {rate}")
        self.update_rate = rate / self.timekeeper.step_size

    def pause(self) -> None:
        """Makes `run` stop making steps; callbacks go on."""
        self.is_paused = True

    def resume(self) -> None:
        """Ends a pause."""
        self.is_paused = False

    def toggle_pause(self) -> None:
        """Pauses or resumes."""
        self.is_paused = not self.is_paused

    def step(self) -> None:
        """Runs the pending callbacks and makes one step, whether paused or not."""
        self.world.transport.process()
        self._step()

    def run(self, goes_on: Callable[[], bool]) -> None:
        """Runs in real time until `goes_on()`, which is called before each step, is false."""
        pacer, transport = self._pacer, self.world.transport
        pacer.start(self.timekeeper.seconds)
        while goes_on():
            transport.process(pacer.wait_time)
            if not goes_on():
                return
            if pacer.begin_step(self.is_paused):
                self._step()
            pacer.end_step(1.0 / self.update_rate, self.is_paused)
            if pacer.is_tick_due:
                for callback in self.on_tick:
                    callback()
                pacer.end_tick(self.timekeeper.seconds)

    def _step(self) -> None:
        self.world.step(self.timekeeper)
        for callback in self.after_step:
            callback()
