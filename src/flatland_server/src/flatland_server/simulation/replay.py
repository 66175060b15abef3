"""Repeats a part of a run, in a world of its own."""

from typing import Any, List, NamedTuple, Tuple, Union

from flatland_server.simulation.run import Run
from flatland_server.timekeeper import Timekeeper
from flatland_server.transport.local_transport import LocalTransport
from flatland_server.transport.transport import Transport


class Command(NamedTuple):
    """A command that was given to a plugin itself."""

    model: str
    plugin: str
    values: Tuple[Any, ...]


class Message(NamedTuple):
    """A message that came to plugins from outside."""

    topic: str
    message: Any


Input = Tuple[int, Union[Command, Message]]
"""A simulated time [ns], and what came then."""


class Replay:
    """A second world of the files of a run, without subscribers, so that it is not noticed.

    Args:
        run: has the world.
    """

    def __init__(self, run: Run) -> None:
        self._transport = _Transport(run.transport)
        self._run = Run(run.world.twin(self._transport), Timekeeper(run.step_size))

    def state_at(self, nanoseconds: int, state: bytes, inputs: List[Input]) -> bytes:
        """The state at a time.

        Args:
            nanoseconds: the time.
            state: of `Run.save_state`, at this time or before.
            inputs: came since then, in their order.
        """
        self._run.load_state(state)
        for due, event in inputs:
            self._step_to(due)
            self._apply(event)
        self._step_to(nanoseconds)
        return self._run.save_state()

    def close(self) -> None:
        """Stops its plugins."""
        self._run.close()

    def _step_to(self, nanoseconds: int) -> None:
        timekeeper = self._run.timekeeper
        count = (nanoseconds - timekeeper.nanoseconds) // timekeeper.step_nanoseconds
        if count > 0:
            self._run.step(count)

    def _apply(self, event: Union[Command, Message]) -> None:
        if isinstance(event, Message):
            self._transport.send(event.topic, event.message)
            self._transport.process()
            return
        plugin = self._run.world.plugins_of(event.model).get(event.plugin)
        if plugin is not None:  # else it was switched off meanwhile
            plugin.command(*event.values)  # type: ignore[attr-defined]


class _Transport(LocalTransport):
    """Has the names and parameters of another transport, and no subscribers but plugins."""

    def __init__(self, original: Transport) -> None:
        super().__init__({}, ())
        self._original = original
        self.tf_by_namespace = original.tf_by_namespace
        self._is_delivering = original.delivers_own

    @property
    def node_name(self) -> str:
        return self._original.node_name

    def resolve(self, name: str) -> str:
        return self._original.resolve(name)

    def get_param(self, name: str, default: Any = None) -> Any:
        return self._original.get_param(name, default)
