"""The plugins of a batch that move bodies at their updates; see `BatchMotion`."""

from typing import List, NamedTuple, Optional, Sequence

import numpy as np

from flatland2d.batch.robot import PluginRole
from flatland_server import _core
from flatland_server.arrays import BoolArray, FloatArray, IntArray, Segments
from flatland_server.plugins.batch_role import BatchMotion
from flatland_server.plugins.plugin_factory import plugin_rng
from flatland_server.update_timer import due_after


class _Entry(NamedTuple):
    """A plugin, and when its next update is due in each environment [ns]."""

    owner: str
    name: str
    motion: BatchMotion
    bodies: List[_core.Body]
    moved: List[_core.Body]
    due: FloatArray


class BatchMotions:
    """The motions of all plugins, in the environments of a batch.

    Args:
        roles: of the plugins.
        count: number of environments, n.
        step_nanoseconds: length of a step.
    """

    def __init__(self, roles: Sequence[PluginRole], count: int, step_nanoseconds: int) -> None:
        self._step = step_nanoseconds
        self._entries: List[_Entry] = []
        for owner, name, role in roles:
            motion = role.make_motion(count) if role.make_motion is not None else None
            if motion is not None and motion.moved:
                parts = list(motion.bodies), list(motion.moved)
                self._entries.append(_Entry(owner, name, motion, *parts, np.zeros(count)))

    def __bool__(self) -> bool:
        return bool(self._entries)

    def begin(self, environment: int, seed: int, walls: Optional[Sequence[Segments]]) -> None:
        """Resets an environment, with a seed and the walls of its world."""
        for each in self._entries:
            each.due[environment] = 0.0
            each.motion.begin(environment, plugin_rng(seed, each.owner, each.name), walls)

    def update(
        self, core: _core.WorldBatch, chosen: Optional[BoolArray], times: IntArray, most: int
    ) -> int:
        """Makes the updates that are due; returns the number of steps until the next one is.

        Args:
            core: the batch.
            chosen: which environments, (n,); None: all. The others are not looked at.
            times: of the environments now [ns], (n,).
            most: upper limit of the result.
        """
        for each in self._entries:
            is_due = times >= each.due
            if chosen is not None:
                is_due &= chosen
            if is_due.any():
                self._update(core, each, is_due)
                each.due[is_due] = due_after(times[is_due], each.motion.rate)
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
