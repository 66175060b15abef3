"""A run that keeps its history: states, from which it goes back to any of its times.

A time between two states is computed from the one before, in a second world, which the run does
not notice. For that the inputs are kept: commands, and messages to plugins. Other changes from
outside, such as spawns, are not repeated; a state is kept after each.
"""

import pickle
import zlib
from contextlib import suppress
from io import BytesIO
from time import monotonic
from typing import Any, Iterable, Iterator, List, NamedTuple, Optional, Tuple, TypeVar

from flatland_server.arguments import shown
from flatland_server.exceptions import StateError, UsageError
from flatland_server.simulation.run import Run
from flatland_server.timekeeper import Timekeeper
from flatland_server.transport.local_transport import LocalTransport
from flatland_server.transport.transport import Recipient, Transport

R = TypeVar("R", bound="RunWithHistory")

SHARE_OF_VIEWERS = 0.05
"""The largest part of the real time that a server or viewer spends on keeping states."""

_MOST = 1e18
"""Greatest value of an argument."""

_PART_SIZE = 50_000
"""Bytes of inputs that are compressed at once, roughly."""


class _Entry(NamedTuple):
    nanoseconds: int
    data: bytes
    """Compressed: a state, or inputs since the entry before."""
    is_state: bool
    is_needed: bool = False
    """True for a state that cannot be computed from the one before."""


_Input = Tuple[int, Recipient, Any]
"""Simulated time [ns], recipient, and message or values of the command."""


class History:
    """Keeps states of a run, while it is open.

    Args:
        run: may have passed some time already; the history begins at present.
        interval: simulated time between two states [s].
        memory: limit of the memory for states [bytes]. If they need more, every second one is
            dropped, and the interval doubled.
        share: the largest part of the real time that may be spent on keeping states; if they take
            more, fewer are kept.

    Attributes:
        is_open: False once it is closed.

    Raises:
        UsageError: an argument is not above zero.
        StateError: the state of the run cannot be saved.
    """

    def __init__(
        self, run: Run, interval: float = 1.0, memory: int = 64_000_000, share: float = 1.0
    ) -> None:
        for value, what in ((interval, "an interval"), (memory, "a memory"), (share, "a share")):
            if not (isinstance(value, (int, float)) and 0 < value <= _MOST):
                raise UsageError(f"expected {what} above 0, found {shown(value)}")
        self._run, self._timekeeper = run, run.timekeeper
        self._interval = round(interval * 1e9)
        self._memory, self._share = memory, share
        self._entries: List[_Entry] = []  # up to the last time, or to one that was sought
        self._whole: List[_Entry] = []  # up to the last time, while in the past
        self._inputs = bytearray()  # since the last entry, pickled one after the other
        self._seen: Tuple[object, int] = (None, 0)  # `_changes` at the last entry
        self._twin: Optional[_Twin] = None
        self.restart()
        if self._problem is not None:
            raise self._problem
        self.is_open = True
        run.after_step.append(self._follow)
        run.after_jump.append(self.restart)
        run.transport.on_input = self._note

    @property
    def span(self) -> Tuple[int, int]:
        """The first and the last time [ns].

        The last one is the present, unless an earlier one was sought.
        """
        now = self._timekeeper.nanoseconds
        begin = self._entries[0].nanoseconds if self._entries else now
        return begin, self._whole[-1].nanoseconds if self._whole else now

    @property
    def begin(self) -> float:
        """The first time [s]."""
        return self.span[0] * 1e-9

    @property
    def end(self) -> float:
        """The last time [s]."""
        return self.span[1] * 1e-9

    @property
    def size(self) -> int:
        """The memory that it needs for states and inputs [bytes], without Python's objects."""
        return self._size + len(self._inputs)

    def seek(self, time: float) -> None:
        """Puts the run into its state at a time; see `RunWithHistory.seek`.

        Args:
            time: within `begin` and `end` [s].

        Raises:
            UsageError: the time is no number, or not within these.
            StateError: the states could not be kept, or do not fit.
        """
        now, has_changed = self._timekeeper.nanoseconds, self._seen != self._changes
        last_state = [each.nanoseconds for each in self._entries[-1:] if each.is_state]
        if not self._whole and (has_changed or self._inputs or last_state != [now]):
            self._keep(has_changed)  # the present, to be able to come back
        if not self._entries:
            raise StateError(f"there is no history: {self._problem}")
        target = self._step_at(time)
        if target == now and not self._whole:
            return
        whole = self._whole or self._entries
        states = [index for index, each in enumerate(whole) if each.is_state]
        begin = max(index for index in states if whole[index].nanoseconds <= target)
        end = next((index for index in states if index > begin), len(whole))
        state = self._state_at(target, *whole[begin:end])
        self._run.after_jump.remove(self.restart)
        try:
            self._run.load_state(state)
        finally:
            self._run.after_jump.append(self.restart)
        self._inputs.clear()
        self._seen, self._due = self._changes, target + self._interval
        if begin == states[-1]:
            self._whole = []
            self._set(whole)
        else:  # its parts may have later inputs, too, but nothing later is computed from them
            self._whole = whole
            self._set(whole[: end if whole[begin].nanoseconds < target else begin])
            self._add(state, is_state=True, is_needed=True)

    def restart(self) -> None:
        """Forgets all states, and begins with the present one."""
        self._forget()
        self._keep(is_needed=True)

    def close(self) -> None:
        """Forgets all states; the run goes on without a history."""
        if self.is_open:
            self.is_open = False
            self._run.after_step.remove(self._follow)
            self._run.after_jump.remove(self.restart)
            if self._run.transport.on_input == self._note:  # not that of a later history
                self._run.transport.on_input = None
        self._forget()

    # What happens to the run

    def _note(self, recipient: Recipient, value: Any) -> None:
        """Keeps an input as it is now: its sender may change the object later."""
        try:
            self._inputs += pickle.dumps((self._timekeeper.nanoseconds, recipient, value), 4)
        except Exception:  # it cannot be repeated, so a state is kept after the next step
            self._seen = (None, 0)
        if len(self._inputs) > _PART_SIZE:
            self._pack()
            self._limit_memory()

    def _follow(self) -> None:
        """Keeps a state if one is due; called after each step."""
        if self._whole:  # what came later is forgotten, if the run goes on from the past
            self._whole = []
        deferred, (seen, revision) = self._run.world.contents.deferred, self._seen
        has_changed = deferred is not seen or deferred.revision != revision  # `_changes`, faster
        late = self._timekeeper.nanoseconds - self._due
        if not has_changed:
            if late < 0 or monotonic() < self._next:
                return
            if late < self._interval and self._run.transport.has_to_deliver:
                return  # states have no messages that are on their way
        self._keep(has_changed or not self._entries)
        self._limit_memory()

    @property
    def _changes(self) -> Tuple[object, int]:
        """Another value after each change of the world from outside."""
        deferred = self._run.world.contents.deferred
        return deferred, deferred.revision

    # Entries

    def _keep(self, is_needed: bool) -> None:
        """Keeps the present state."""
        begin, now = monotonic(), self._timekeeper.nanoseconds
        try:
            state = self._run.save_state()
        except StateError as error:  # as after the spawn of a model without a file
            self._forget(error)
        else:
            self._pack()
            self._add(state, is_state=True, is_needed=is_needed)
        self._seen, self._due = self._changes, now + self._interval
        self._next = begin + (monotonic() - begin) / self._share

    def _pack(self) -> None:
        if self._inputs and self._entries:
            self._add(bytes(self._inputs), is_state=False)
        self._inputs.clear()

    def _add(self, data: bytes, is_state: bool, is_needed: bool = False) -> None:
        now, compressed = self._timekeeper.nanoseconds, zlib.compress(data, 1)
        self._entries.append(_Entry(now, compressed, is_state, is_needed))
        self._size += len(compressed)

    def _limit_memory(self) -> None:
        """Drops every second state if they fill the memory; the oldest ones if inputs do."""
        if self._size <= self._memory:
            return
        computable = [each for each in self._entries if each.is_state and not each.is_needed]
        if sum(len(each.data) for each in computable) > self._memory / 2:
            dropped = set(computable[1::2])
            self._set([each for each in self._entries if each not in dropped])
            self._interval *= 2
        states = [index for index, each in enumerate(self._entries) if each.is_state]
        if self._size > self._memory and len(states) > 1:
            self._set(self._entries[states[(len(states) + 3) // 4] :])
        elif self._size > self._memory and len(self._entries) > 1:  # as in a long pause
            self._forget()

    def _set(self, entries: List[_Entry]) -> None:
        self._entries = entries
        self._size = sum(len(each.data) for each in entries)

    def _forget(self, problem: Optional[StateError] = None) -> None:
        if self._twin is not None:
            self._twin.close()
        self._twin, self._problem, self._whole = None, problem, []
        self._inputs.clear()
        self._set([])
        self._due, self._next = 0, 0.0  # simulated [ns] and real time [s] of the next state

    # Times

    def _step_at(self, seconds: float) -> int:
        """The time of the step that is nearest to a time [ns].

        Raises:
            UsageError: the time is no number, or not within the history.
        """
        (first, last), step = self.span, self._timekeeper.step_nanoseconds
        try:
            index = round((float(seconds) * 1e9 - first) / step)
        except (TypeError, ValueError, OverflowError):
            index = -1
        if not 0 <= index * step <= last - first:
            raise UsageError(
                f"expected a time from {self.begin:.10g} to {self.end:.10g} s, which the history "
                f"has, found {shown(seconds)}"
            )
        return first + index * step

    def _state_at(self, target: int, before: _Entry, *parts: _Entry) -> bytes:
        """The state at a time [ns], from the one before and the inputs since."""
        state = zlib.decompress(before.data)
        inputs = [each for each in _inputs_in(parts) if each[0] <= target]
        if before.nanoseconds == target and not inputs:
            return state
        if self._twin is None:
            world = self._run.world.twin(_TwinTransport(self._run.transport))
            self._twin = _Twin(world, Timekeeper(self._run.step_size))
        return self._twin.repeat(state, inputs, target)


def _inputs_in(parts: Iterable[_Entry]) -> Iterator[_Input]:
    stream = BytesIO(b"".join(zlib.decompress(part.data) for part in parts))
    with suppress(EOFError):
        while True:
            yield pickle.load(stream)


class _Twin(Run):
    """A second world of the files of a run, without subscribers."""

    transport: LocalTransport

    def repeat(self, state: bytes, inputs: Iterable[_Input], until: int) -> bytes:
        """The state at a time [ns], from an earlier one and the inputs since."""
        self.load_state(state)
        for nanoseconds, recipient, value in inputs:
            self._step_to(nanoseconds)
            if isinstance(recipient, str):
                self.transport.send(recipient, value)
                self.transport.process()
            elif (plugin := self.world.plugins_of(recipient[0]).get(recipient[1])) is not None:
                plugin.command(*value)  # type: ignore[attr-defined] # else it was switched off
        self._step_to(until)
        return self.save_state()

    def _step_to(self, nanoseconds: int) -> None:
        steps = (nanoseconds - self.timekeeper.nanoseconds) // self.timekeeper.step_nanoseconds
        if steps:
            self.step(steps)


class _TwinTransport(LocalTransport):
    """Has the names and parameters of another transport, and no subscribers but plugins."""

    def __init__(self, original: Transport) -> None:
        super().__init__({}, ())
        self._original = original
        self.tf_by_namespace = original.tf_by_namespace
        # Over ROS, what a plugin publishes comes back to others as an input.
        self._is_delivering = isinstance(original, LocalTransport)

    @property
    def node_name(self) -> str:
        return self._original.node_name

    def resolve(self, name: str) -> str:
        return self._original.resolve(name)

    def get_param(self, name: str, default: Any = None) -> Any:
        return self._original.get_param(name, default)


class RunWithHistory(Run):
    """A run in which time can be sought, once it keeps states; until then it is as any other.

    Args: those of `Run`.
    """

    _history: Optional[History] = None

    @property
    def history(self) -> Optional[History]:
        """The states that are kept for `seek`, if any."""
        return self._history if self._history is not None and self._history.is_open else None

    def keep_history(
        self, interval: float = 1.0, memory: int = 64_000_000, share: float = 1.0
    ) -> History:
        """Begins to keep states of the run as it goes, for `seek`; replaces a former history.

        Args:
            interval: as for `History`.
            memory: as for `History`.
            share: as for `History`.
        """
        self.require_open()
        history = History(self, interval, memory, share)
        if self.history is not None:
            self.history.close()
        self._history = history
        return history

    def seek(self: R, time: float) -> R:
        """Puts the run into its state at another time, bit for bit, and returns this run.

        Once it goes on from there, what came later is forgotten. See `load_state`.

        Args:
            time: since `keep_history` was called [s]; the nearest step.

        Raises:
            FlatlandError: the history does not have this time, or a step is being made.
        """
        self.require_open()
        self.world.require_between_steps("seek")
        if self.history is None:
            raise UsageError("expected keep_history() before the steps to which seek goes back")
        self.history.seek(time)
        return self

    def close(self) -> None:
        """Stops all plugins. Later calls raise a UsageError; poses may still be read."""
        if self.history is not None:
            self.history.close()
        super().close()
