"""A world that a program steps: what `Simulation` and the `Simulation` of tests have in common."""

from typing import Any, List, Optional, Tuple

from flatland_server.exceptions import PluginError, UsageError
from flatland_server.library.arguments import shown
from flatland_server.plugins.plugin_manager import PluginFailure
from flatland_server.simulation.world import World
from flatland_server.timekeeper import LONGEST_STEP, Timekeeper
from flatland_server.transport.local_transport import LocalTransport


class SimulatedWorld:
    """A world and its time. Time passes only in steps, and topics stay in this process.

    Args:
        world: what is simulated; its transport must be a `LocalTransport`.
        step_size: length of a step [s].

    Attributes:
        world: the layers, models and plugins, and the physics.
        timekeeper: counts the simulated time.

    Raises:
        UsageError: the transport is another one, or the step is no length of time.
    """

    def __init__(self, world: World, step_size: float = 0.005) -> None:
        if not isinstance(world.transport, LocalTransport):
            raise UsageError(
                f"expected a world with a LocalTransport, found {type(world.transport).__name__}"
            )
        self.world = world
        self.timekeeper = new_timekeeper(step_size)
        self._transport = world.transport
        self._settled = -1  # the activity of the transport before the last step; -1 is not known
        self._failures: List[Tuple[PluginFailure, BaseException]] = []

    @property
    def transport(self) -> LocalTransport:
        """The topics and transforms of the world."""
        return self._transport

    def _advance(self, limit: int = 1) -> int:
        """Makes one step or several, and returns how many; see `World.step_up_to`.

        First, messages that were sent are received.
        """
        self._settled = -1
        activity = self._transport.activity
        self._transport.process()
        steps = self.world.step_up_to(self.timekeeper, limit)
        self._settled = activity
        return steps

    def _note_failure(self, failure: PluginFailure, error: BaseException) -> None:
        self._failures.append((failure, error))

    def _raise_failures(self) -> None:
        """Raises the first failure of a plugin that was noted since the last call."""
        if self._failures:
            failure, error = self._failures[0]
            self._failures.clear()
            raise PluginError(f'the plugin "{failure.label}" failed in {failure.reason}') from error

    def _reset(self, seed: Optional[int]) -> None:
        self.world.require_between_steps("reset")
        self.world.reset(seed)
        self.timekeeper.jump_to(0)

    def _load_state(self, state: bytes) -> None:
        self.world.load_state(state, self.timekeeper)

    def save_state(self) -> bytes:
        """The state of the world and the time, for `load_state`: here, or in another process.

        From here on, this world goes on, bit for bit, like each one that loads the state.

        Raises:
            StateError: a plugin's state cannot be saved.
        """
        return self.world.save_state(self.timekeeper)

    def last(self, topic: str) -> Any:
        """The newest message of a topic; None if there is none yet.

        Args:
            topic: its name.
        """
        return self.transport.last(topic)


def new_timekeeper(step_size: float) -> Timekeeper:
    """A timekeeper.

    Raises:
        UsageError: the step is no length of time.
    """
    try:
        return Timekeeper(float(step_size))
    except (TypeError, ValueError):
        expected = f"expected a step of 1e-9 to {LONGEST_STEP:g} s"
        raise UsageError(f"{expected}, found {shown(step_size)}") from None
