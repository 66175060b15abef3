"""The random numbers of crowds and drives in a batch."""

from contextlib import contextmanager
from typing import Iterator, List, Optional, Sequence, Tuple, Union

import numpy as np

from flatland2d.batch.robot import PluginRole
from flatland_server import _core
from flatland_server.arrays import BoolArray, IntArray
from flatland_server.plugins import plugin_rng
from flatland_server.simulation import World


def find_scattered(
    world: World, roles: Sequence[PluginRole]
) -> Tuple[List[PluginRole], Optional[PluginRole]]:
    """The crowd that draws its places in each environment of a shared world.

    Returns:
        The roles, and the one of the crowd. None: there is no such crowd, or something else was
        drawn or changed after it: then its role is that worlds differ by their seeds.
    """
    drawn = [each for each in roles if each.role.before_scatter is not None]
    if len(drawn) == 1 and not any(each.role.varies_by_seed for each in roles):
        physics, role = world.physics, drawn[0].role
        assert role.crowd is not None
        assert role.before_scatter is not None
        present = physics.save_state()
        try:
            physics.restore_state(role.before_scatter)
            role.crowd.scatter()
            is_last = physics.save_state() == present
        except ValueError:  # there were fewer bodies
            is_last = False
        physics.restore_state(present)
        if is_last:
            return list(roles), drawn[0]
    return [
        each._replace(role=each.role._replace(varies_by_seed=True)) if each in drawn else each
        for each in roles
    ], None


@contextmanager
def as_before_scatter(world: World, scattered: Optional[PluginRole]) -> Iterator[None]:
    """A block in which the people of a crowd have drawn no places yet."""
    if scattered is None or scattered.role.before_scatter is None:
        yield
        return
    present = world.physics.save_state()
    world.physics.restore_state(scattered.role.before_scatter)
    yield
    world.physics.restore_state(present)


class BatchRandomness:
    """Gives the crowds and drives of each environment the random numbers of its seed.

    Args:
        roles: of the plugins.
        count: number of environments, n.
        scattered: the one with a crowd that draws its places at each reset.
    """

    def __init__(
        self, roles: Sequence[PluginRole], count: int, scattered: Optional[PluginRole] = None
    ) -> None:
        self._scattered = scattered
        self._owners: List[
            Tuple[str, str, Union[_core.Crowd, _core.Drive, _core.Tricycle, _core.Ackermann]]
        ] = []
        for owner, name, _, role in roles:
            if role.crowd is not None:
                self._owners.append((owner, name, role.crowd))
            if role.drive is not None and role.drive.is_random:
                self._owners.append((owner, name, role.drive.drive))
        self._seeds = np.full(count, -1, np.int64)
        self._keys = np.zeros((len(self._owners), count), np.uint64)

    def __bool__(self) -> bool:
        return bool(self._owners)

    def begin(self, core: _core.WorldBatch, environments: Sequence[int], seeds: IntArray) -> None:
        """Begins the random numbers of environments with their seeds (n,), after a reset."""
        mask = np.zeros(len(self._seeds), bool)
        mask[environments] = True
        self._draw(mask, seeds)
        for row, (_, _, each) in zip(self._keys, self._owners):
            core.seed(each, row, mask)

    def scatter(self, core: _core.WorldBatch, chosen: Optional[BoolArray], seeds: IntArray) -> None:
        """Lets the crowd draw places in the next reset of environments, with their seeds (n,)."""
        if self._scattered is None:
            return
        self._draw(np.ones(len(seeds), bool) if chosen is None else chosen, seeds)
        for row, (_, _, each) in zip(self._keys, self._owners):
            if each is self._scattered.role.crowd:
                core.scatter(self._scattered.role.crowd, row, chosen)

    def _draw(self, mask: BoolArray, seeds: IntArray) -> None:
        """Draws the keys of environments with new seeds."""
        for k in np.flatnonzero(mask & (self._seeds != seeds)).tolist():
            for row, (owner, name, _) in zip(self._keys, self._owners):
                row[k] = plugin_rng(int(seeds[k]), owner, name).integers(2**63)
        self._seeds[mask] = seeds[mask]
