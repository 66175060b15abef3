"""Progresses the world through time, as fast as asked for."""

import math
import time
from typing import Callable, List

from flatland_server.timekeeper import Timekeeper
from flatland_server.world import World

_LONGEST_BACKLOG = 0.25
"""How much lost time [s] is caught up; what is more is lost for good."""

_WAIT_WHILE_PAUSED = 0.01
"""How long a paused simulation of unbounded rate waits for something to do [s]."""


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
        self.update_rate = update_rate
        self.is_paused = False
        self.after_step: List[Callable[[], None]] = []
        """Called after each step."""
        self.each_turn: List[Callable[[], None]] = []
        """Called at the update rate, also while the simulation is paused."""

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
        next_turn = time.monotonic()
        while goes_on():
            if math.isinf(self.update_rate):
                self.world.transport.process(_WAIT_WHILE_PAUSED if self.is_paused else 0.0)
            else:
                now = time.monotonic()
                self.world.transport.process(max(0.0, next_turn - now))
                next_turn = max(next_turn, now - _LONGEST_BACKLOG) + 1.0 / self.update_rate
            if not goes_on():
                return
            if not self.is_paused:
                self._step()
            for listener in self.each_turn:
                listener()
