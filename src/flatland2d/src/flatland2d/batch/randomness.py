"""The random numbers of crowds and drives in a batch."""

from typing import List, Sequence, Tuple, Union

import numpy as np

from flatland2d.batch.robot import PluginRole
from flatland_server import _core
from flatland_server.arrays import IntArray
from flatland_server.plugins import plugin_rng


class BatchRandomness:
    """Gives the crowds and drives of each environment the random numbers of its seed.

    Args:
        roles: of the plugins.
        count: number of environments, n.
    """

    def __init__(self, roles: Sequence[PluginRole], count: int) -> None:
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
        for k in np.flatnonzero(mask & (self._seeds != seeds)).tolist():
            for row, (owner, name, _) in zip(self._keys, self._owners):
                row[k] = plugin_rng(int(seeds[k]), owner, name).integers(2**63)
        self._seeds[mask] = seeds[mask]
        for row, (_, _, each) in zip(self._keys, self._owners):
            core.seed(each, row, mask)
