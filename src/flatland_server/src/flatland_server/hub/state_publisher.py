"""~state: whether the simulation is paused, and its rate, for graphical front ends.

Its times are simulated ones, whatever the stamps of other messages are: /seek takes them.
"""

import time

from flatland_server.hub.client_edits import ClientEdits
from flatland_server.messages.message_types import TYPES, get
from flatland_server.simulation.simulation_manager import SimulationManager

SimulationState = get("flatland_msgs/SimulationState")

_PERIOD = 0.2
"""Seconds of real time between two messages; a change by a client is published at once."""


class StatePublisher:
    """Publishes flatland_msgs/SimulationState, latched.

    Args:
        manager: simulation with the state.
        edits: edits that can be undone, redone and saved.
    """

    def __init__(self, manager: SimulationManager, edits: ClientEdits) -> None:
        self._manager = manager
        self._edits = edits
        transport = manager.transport
        self._publisher = transport.advertise(
            f"{transport.node_name}/state", SimulationState, latch=True, queue_size=1
        )
        self._due = 0.0
        self._published = (False, 0.0, 0)

    def update(self) -> None:
        """Publishes if it is time to; to be called often."""
        manager = self._manager
        requested = (not manager.is_stepping, manager.rate, self._edits.revision)
        now = time.monotonic()
        if now < self._due and requested == self._published:
            return
        self._due = now + _PERIOD
        self._published = requested
        now_simulated = manager.timekeeper.nanoseconds
        begin, end = manager.history.span if manager.history else (now_simulated, now_simulated)
        paused, rate, _ = requested
        state = SimulationState(
            TYPES.Time(0, now_simulated),
            paused,
            rate,
            manager.pacer.real_time_factor,
            TYPES.Time(0, begin),
            TYPES.Time(0, end),
            self._edits.count,
            *self._edits.next_texts,
        )
        self._publisher.publish(state)
