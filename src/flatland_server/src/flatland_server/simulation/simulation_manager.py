"""Progresses the world through time, as fast as asked for."""

import time
from collections import deque
from typing import Callable, Deque, List

from flatland_server.simulation.world import World
from flatland_server.timekeeper import Timekeeper

_LONGEST_BACKLOG = 0.25
"""How much lost time [s] is caught up; what is more is lost for good."""

_LONGEST_TICK = 0.02
"""How long it waits at most for the next step before it lets listeners have a turn [s]."""

_SHORTEST_TICK = 0.001
"""How long it makes steps without waiting before it lets listeners have a turn [s]."""

_REMEMBERED_STEPS = 1001
"""Whose times are kept, to tell how punctual they are."""

_METERING_TIME = 1.0
"""Real time over which the rate is measured [s]."""


class SimulationManager:
    """Runs a world: steps it at a rate of real time, and lets commands in between the steps.

    Args:
        world: what is stepped.
        timekeeper: counts the simulated time.
        update_rate: steps per second of real time; infinity is as fast as the machine can.

    Raises:
        ValueError: the rate is not above zero.
    """

    def __init__(self, world: World, timekeeper: Timekeeper, update_rate: float = 200.0) -> None:
        if not update_rate > 0:
            raise ValueError(f"expected an update rate above 0 Hz, found {update_rate}")
        self.world = world
        self.timekeeper = timekeeper
        self.change_rate(update_rate * timekeeper.step_size)
        self.is_paused = False
        self.real_time_factor = 0.0
        """Simulated seconds per second of real time, in the last second or so of `run`."""
        self._step_times: Deque[float] = deque(maxlen=_REMEMBERED_STEPS)
        self.after_step: List[Callable[[], None]] = []
        """Called after each step."""
        self.on_tick: List[Callable[[], None]] = []
        """Called before each wait and every now and then, also while the simulation is paused."""

    @property
    def rate(self) -> float:
        """Simulated seconds per second of real time that are asked for; may be infinite."""
        return self.update_rate * self.timekeeper.step_size

    def change_rate(self, rate: float) -> None:
        """Asks for another `rate`: 1 is real time, infinity as fast as the machine can.

        Raises:
            ValueError: the rate is not above zero.
        """
        if not rate > 0:
            raise ValueError(f"expected a rate above 0, found {rate}")
        self.update_rate = rate / self.timekeeper.step_size

    @property
    def step_periods(self) -> List[float]:
        """Real time from each of the latest steps of `run` to the next, without a pause [s]."""
        times = list(self._step_times)
        return [later - earlier for earlier, later in zip(times, times[1:])]

    def pause(self) -> None:
        """Stops time."""
        self.is_paused = True

    def resume(self) -> None:
        """Lets time go on."""
        self.is_paused = False

    def toggle_pause(self) -> None:
        """Stops time, or lets it go on."""
        self.is_paused = not self.is_paused

    def step(self) -> None:
        """Runs the callbacks that wait, and makes one step, whether paused or not."""
        self.world.transport.process()
        self._step()

    def _step(self) -> None:
        self.world.step(self.timekeeper)
        for listener in self.after_step:
            listener()

    def run(self, goes_on: Callable[[], bool]) -> None:
        """Runs until `goes_on()` is false; asks before each step."""
        due = turn = now = time.monotonic()
        metered = (now, self.timekeeper.seconds)
        while goes_on():
            wait = max(0.0, due - now)
            self.world.transport.process(min(wait, _LONGEST_TICK))
            if not goes_on():
                return
            if wait > 0.0:
                now = time.monotonic()
            if now >= due:
                last = max(due, now - _LONGEST_BACKLOG)
                if self.is_paused:
                    self._step_times.clear()
                else:
                    self._step_times.append(now)
                    self._step()
                    now = time.monotonic()
            period = 1.0 / self.update_rate  # it may have been changed
            due = last + (max(period, _LONGEST_TICK) if self.is_paused else period)
            if due <= now < turn:
                continue
            for listener in self.on_tick:
                listener()
            now = time.monotonic()
            turn = now + _SHORTEST_TICK
            if now - metered[0] >= _METERING_TIME:
                seconds = self.timekeeper.seconds
                self.real_time_factor = (seconds - metered[1]) / (now - metered[0])
                metered = (now, seconds)
