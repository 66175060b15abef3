"""The history of a run: states that are kept as it goes, to go back to any of its moments.

A moment has a state, and what came from outside until the next one: commands, and messages to
plugins. A moment in between is computed by a `Replay` from the one before, out of sight of the run.
Changes of the world from outside, such as spawns, are not replayed; a state is kept after each.
"""

import pickle
import time
import zlib
from dataclasses import dataclass, field
from functools import wraps
from typing import Any, Callable, List, Optional, Tuple

from flatland_server.arguments import shown
from flatland_server.exceptions import StateError, UsageError
from flatland_server.simulation.replay import Command, Input, Message, Replay
from flatland_server.simulation.run import Run

SHARE_OF_VIEWERS = 0.05
"""The largest part of the real time that a server or viewer spends on keeping states."""

_MOST_INPUTS = 100
"""As many inputs are packed at once."""
_INPUT_SIZE = 300
"""Bytes of an input that is not packed yet, roughly."""


@dataclass
class _Moment:
    nanoseconds: int
    state: bytes
    """Compressed."""
    is_needed: bool
    """True if no replay leads from the moment before to this one."""
    packed: List[bytes] = field(default_factory=list)
    """The inputs until the next moment, except for those of a last moment: pickled."""

    @property
    def size(self) -> int:
        return len(self.state) + sum(map(len, self.packed))

    def pack(self, inputs: List[Input]) -> None:
        if inputs:
            self.packed.append(zlib.compress(pickle.dumps(inputs, pickle.HIGHEST_PROTOCOL), 1))

    def unpacked(self) -> List[Input]:
        return [each for part in self.packed for each in pickle.loads(zlib.decompress(part))]


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
            if not (isinstance(value, (int, float)) and value > 0):
                raise UsageError(f"expected {what} above 0, found {shown(value)}")
        self._run = run
        self._timekeeper = run.timekeeper
        self._interval = round(interval * 1e9)
        self._memory, self._share = memory, share
        self._moments: List[_Moment] = []
        self._size = 0
        self._inputs: List[Input] = []  # since the last moment, or since a moment was sought
        self._sought: Optional[int] = None  # the index of the moment before, while in the past
        self._replay: Optional[Replay] = None
        self._problem: Optional[StateError] = None
        self._is_seeking = False
        self._changes: Tuple[object, int] = (None, 0)
        self._due = 0  # simulated time of the next state [ns]
        self._may_keep = 0.0  # real time from which on it may be kept [s]
        self.restart()
        if self._problem is not None:
            raise self._problem
        self.is_open = True
        run.after_step.append(self._follow)
        run.after_jump.append(self._on_jump)
        run.transport.on_message = self._note_message
        run.world.plugin_revision.change()  # handles of drives note commands from now on

    @property
    def span(self) -> Tuple[int, int]:
        """The times of the first and the last moment [ns].

        The last one is the present, unless an earlier one was sought.
        """
        now = self._timekeeper.nanoseconds
        if not self._moments:
            return now, now
        last = self._moments[-1].nanoseconds if self.is_in_past else now
        return self._moments[0].nanoseconds, last

    @property
    def begin(self) -> float:
        """The time of the first moment [s]."""
        return self.span[0] * 1e-9

    @property
    def end(self) -> float:
        """The time of the last moment [s]."""
        return self.span[1] * 1e-9

    @property
    def size(self) -> int:
        """The memory that it needs for states and inputs [bytes], without Python's objects."""
        return self._size + _INPUT_SIZE * len(self._inputs)

    @property
    def is_in_past(self) -> bool:
        """True if an earlier moment was sought, and the run has not gone on from there."""
        return self._sought is not None

    def seek(self, time: float) -> None:
        """Puts the run into its state at a time; see `RunWithHistory.seek`.

        Args:
            time: within `begin` and `end` [s].

        Raises:
            UsageError: the time is no number, or not within these.
            StateError: the states could not be kept, or do not fit.
        """
        self._require_states()
        target = self._step_at(time)
        if not self.is_in_past:
            if target == self._timekeeper.nanoseconds:
                return
            self._keep_present()  # to be able to come back
            self._require_states()
        moments = self._moments
        index = next(i for i in reversed(range(len(moments))) if moments[i].nanoseconds <= target)
        state = self._state_at(index, target)
        self._is_seeking = True
        try:
            self._run.load_state(state)
        finally:
            self._is_seeking = False
        is_last = index == len(moments) - 1
        self._sought = None if is_last else index
        self._inputs = []
        self._note_changes()

    def recorded(
        self, model: str, plugin: str, command: Callable[..., None]
    ) -> Callable[..., None]:
        """The command of a plugin, as one that is noted here.

        Args:
            model: the name of the plugin's model.
            plugin: the name of the plugin.
            command: its method.
        """

        @wraps(command)
        def noted(*values: Any) -> None:
            command(*values)
            self._note(Command(model, plugin, values))

        return noted

    def close(self) -> None:
        """Forgets all states; the run goes on without a history."""
        if self.is_open:
            self.is_open = False
            run = self._run
            run.after_step.remove(self._follow)
            run.after_jump.remove(self._on_jump)
            if run.transport.on_message == self._note_message:  # not that of a later history
                run.transport.on_message = None
            run.world.plugin_revision.change()
        self._forget()

    # What happens to the run

    def _note_message(self, topic: str, message: Any) -> None:
        self._note(Message(topic, message))

    def _note(self, event: Any) -> None:
        self._inputs.append((self._timekeeper.nanoseconds, event))
        if len(self._inputs) >= _MOST_INPUTS and self._moments and not self.is_in_past:
            self._pack_inputs()

    def _follow(self) -> None:
        """Keeps a state if one is due; called after each step."""
        if self._sought is not None:
            self._go_on(self._sought)
        has_changed = self._has_changed()
        if not has_changed:
            if self._timekeeper.nanoseconds < self._due:
                return
            if self._share < 1.0 and time.monotonic() < self._may_keep:
                return
            if self._run.transport.has_to_deliver and self._timekeeper.nanoseconds < (
                self._due + self._interval
            ):
                return  # states have no messages that are on their way
        self._keep(is_needed=has_changed)
        if self._size > self._memory:
            self._shrink()

    def _on_jump(self) -> None:
        if not self._is_seeking:
            self.restart()

    def _has_changed(self) -> bool:
        deferred = self._run.world.contents.deferred
        return self._changes != (deferred, deferred.revision)

    def _note_changes(self) -> None:
        deferred = self._run.world.contents.deferred
        self._changes = (deferred, deferred.revision)

    # Moments

    def restart(self) -> None:
        """Forgets all moments, and begins with the present one."""
        self._forget()
        self._problem = None
        self._keep(is_needed=True)

    def _forget(self) -> None:
        if self._replay is not None:
            self._replay.close()
        self._replay = None
        self._moments, self._inputs, self._size, self._sought = [], [], 0, None

    def _keep(self, is_needed: bool) -> None:
        """Keeps the present state."""
        begin = time.monotonic()
        self._note_changes()
        self._due = self._timekeeper.nanoseconds + self._interval
        try:
            state = zlib.compress(self._run.save_state(), 1)
        except StateError as error:  # as after the spawn of a model without a file
            self._forget()
            self._problem = error
            return
        self._problem = None
        if self._moments:
            self._pack_inputs()
        moment = _Moment(self._timekeeper.nanoseconds, state, is_needed or not self._moments)
        self._moments.append(moment)
        self._size += moment.size
        end = time.monotonic()
        self._may_keep = end + (end - begin) / self._share

    def _keep_present(self) -> None:
        """Keeps the present state, unless the last moment has it."""
        has_changed, last = self._has_changed(), self._moments[-1].nanoseconds
        if has_changed or self._inputs or last != self._timekeeper.nanoseconds:
            self._keep(is_needed=has_changed)

    def _pack_inputs(self) -> None:
        last = self._moments[-1]
        self._size -= last.size
        last.pack(self._inputs)
        self._size += last.size
        self._inputs = []

    def _go_on(self, index: int) -> None:
        """Drops what came after the moment that was sought: the run goes on from there."""
        begun = self._timekeeper.nanoseconds - self._timekeeper.step_nanoseconds
        self._sought = None
        del self._moments[index + 1 :]
        last = self._moments[-1]
        earlier = [each for each in last.unpacked() if each[0] <= begun]
        last.packed.clear()
        self._size = sum(moment.size for moment in self._moments)
        self._inputs = earlier + self._inputs
        self._due = last.nanoseconds + self._interval

    def _shrink(self) -> None:
        """Drops every second moment; or the oldest ones, if inputs need most of the memory."""
        moments = self._moments
        if sum(len(moment.state) for moment in moments) > self._memory / 2:
            thinned = [moments[0]]
            for index, moment in enumerate(moments[1:-1], 1):
                if moment.is_needed or index % 2 == 0:
                    thinned.append(moment)
                else:
                    thinned[-1].packed += moment.packed
            moments = [*thinned, moments[-1]]
            self._interval *= 2
        if sum(moment.size for moment in moments) > self._memory * 3 / 4:
            moments = moments[max(1, len(moments) // 4) :] or moments[-1:]
        self._moments = moments
        self._size = sum(moment.size for moment in moments)

    # Times

    def _require_states(self) -> None:
        if self._problem is not None:
            raise StateError(f"there is no history: {self._problem}")

    def _step_at(self, seconds: float) -> int:
        """The time of the step that is nearest to a time [ns].

        Raises:
            UsageError: the time is no number, or not within the history.
        """
        (first, last), step = self.span, self._timekeeper.step_nanoseconds
        try:
            count = round((float(seconds) * 1e9 - first) / step)
        except (TypeError, ValueError, OverflowError):
            count = -1
        if not 0 <= count * step <= last - first:
            raise UsageError(
                f"expected a time from {self.begin:.10g} to {self.end:.10g} s, which the history "
                f"has, found {shown(seconds)}"
            )
        return first + count * step

    def _state_at(self, index: int, target: int) -> bytes:
        """The state at a time, by a replay from the moment before, if need be."""
        moment = self._moments[index]
        state = zlib.decompress(moment.state)
        inputs = [each for each in moment.unpacked() if each[0] <= target]
        if moment.nanoseconds == target and not inputs:
            return state
        if self._replay is None:
            self._replay = Replay(self._run)
        return self._replay.state_at(target, state, inputs)
