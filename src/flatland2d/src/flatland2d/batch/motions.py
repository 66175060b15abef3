"""The plugins of a batch that move bodies at their updates; see `BatchMotion`."""

from contextlib import contextmanager
from typing import Any, Dict, Iterator, List, NamedTuple, Optional, Sequence

import numpy as np

from flatland2d.batch.robot import PluginRole
from flatland_server import _core
from flatland_server.arrays import BoolArray, FloatArray, IntArray, Segments
from flatland_server.exceptions import PLUGIN_ERRORS, StateError
from flatland_server.plugins import BatchMotion, plugin_label, plugin_rng
from flatland_server.simulation import PluginState
from flatland_server.update_timer import UpdateTimer, due_after


class _Entry(NamedTuple):
    """A plugin, and its update timer and random numbers in each environment."""

    owner: str
    name: str
    type: str
    motion: BatchMotion
    bodies: List[_core.Body]
    moved: List[_core.Body]
    start: IntArray
    """See `UpdateTimer` [ns]."""
    due: FloatArray
    """Time of the next update [ns]."""
    rngs: Dict[int, np.random.Generator]


class BatchMotions:
    """The motions of all plugins, in the environments of a batch.

    Args:
        roles: the roles of the plugins.
        count: number of environments, n.
        step_nanoseconds: length of a step [ns].
    """

    def __init__(self, roles: Sequence[PluginRole], count: int, step_nanoseconds: int) -> None:
        self._step = step_nanoseconds
        self._entries: List[_Entry] = []
        for owner, name, type, role in roles:
            motion = role.make_motion(count) if role.make_motion is not None else None
            if motion is not None and motion.moved:
                parts = list(motion.bodies), list(motion.moved)
                timer = np.zeros(count, np.int64), np.zeros(count)
                self._entries.append(_Entry(owner, name, type, motion, *parts, *timer, {}))

    def __bool__(self) -> bool:
        return bool(self._entries)

    def begin(self, environment: int, seed: int, walls: Optional[Sequence[Segments]]) -> None:
        """Resets an environment, with a seed and the walls of its world."""
        for each in self._entries:
            each.start[environment], each.due[environment] = 0, 0.0
            rng = each.rngs[environment] = plugin_rng(seed, each.owner, each.name)
            each.motion.begin(environment, rng, walls)

    def states(self, environment: int) -> List[PluginState]:
        """The states of the plugins in an environment.

        Raises:
            StateError: one cannot be saved.
        """
        states = []
        for each in self._entries:
            rate = each.motion.rate
            timer = UpdateTimer(rate).get_state()
            timer["start"] = int(each.start[environment])
            timer["due"] = float(each.due[environment])
            rng: Any = each.rngs[environment].bit_generator.state
            with _state_errors(each):
                state = each.motion.get_state(environment)
                states.append(
                    PluginState(each.owner, each.name, each.type, None, rng, timer, state)
                )
        return states

    def set_states(self, environment: int, states: Sequence[PluginState], now: int) -> None:
        """Restores an environment that was begun.

        Args:
            environment: index of the environment, from 0.
            states: those of the motions, and perhaps of other plugins.
            now: the simulated time [ns].

        Raises:
            StateError: the states do not fit.
        """
        by_name = {(each.owner, each.name): each for each in states}
        for each in self._entries:
            with _state_errors(each):
                state = by_name[each.owner, each.name]
                if state.timer is None or state.failure is not None:
                    raise ValueError("expected a plugin that runs, with a timer")
                due = state.timer["due"]
                each.due[environment] = due
                each.start[environment] = now if due < 0 else state.timer["start"]
                each.rngs[environment].bit_generator.state = state.rng
                each.motion.set_state(environment, state.state)

    def update(
        self, core: _core.WorldBatch, chosen: Optional[BoolArray], times: IntArray, most: int
    ) -> int:
        """Makes the updates that are due; returns the number of steps until the next one is.

        Args:
            core: the batch in the core.
            chosen: which environments, (n,); None: all. The others are not looked at.
            times: of the environments now [ns], (n,).
            most: greatest number of steps to return.
        """
        for each in self._entries:
            is_due = times >= each.due
            if chosen is not None:
                is_due &= chosen
            if is_due.any():
                self._update(core, each, is_due)
                start = each.start[is_due]
                each.due[is_due] = start + due_after(times[is_due] - start, each.motion.rate)
            left = each.due - times
            least = left.min() if chosen is None else left[chosen].min(initial=np.inf)
            most = int(min(most, max(1.0, np.ceil(least / self._step))))
        return most

    def _update(self, core: _core.WorldBatch, each: _Entry, is_due: BoolArray) -> None:
        poses, velocities = core.motions(each.bodies, is_due)
        chosen = np.flatnonzero(is_due)
        new = np.zeros((len(is_due), 3 * len(each.moved)))
        new[chosen] = each.motion.update(
            chosen, poses[chosen], velocities[chosen], self._step * 1e-9
        ).reshape(len(chosen), -1)
        core.set_velocities(each.moved, new, is_due)


@contextmanager
def _state_errors(each: _Entry) -> Iterator[None]:
    """Turns the exceptions of a plugin's motion into StateErrors that name it."""
    try:
        yield
    except PLUGIN_ERRORS as error:
        label = plugin_label(each.owner, each.name)
        raise StateError(f'the plugin "{label}": {type(error).__name__}: {error}') from error
