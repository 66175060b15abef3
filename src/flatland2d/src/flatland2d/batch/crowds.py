"""The random numbers of crowds in a batch."""

from typing import Sequence

import numpy as np

from flatland2d.batch.robot import PluginRole
from flatland_server import _core
from flatland_server.arrays import IntArray
from flatland_server.plugins.plugin_factory import plugin_rng


class BatchCrowds:
    """Gives the crowds of each environment the random numbers of its seed.

    Args:
        roles: of the plugins.
        count: number of environments, n.
    """

    def __init__(self, roles: Sequence[PluginRole], count: int) -> None:
        self._crowds = [
            (owner, name, role.crowd) for owner, name, _, role in roles if role.crowd is not None
        ]
        self._seeds = np.full(count, -1, np.int64)
        self._keys = np.zeros((len(self._crowds), count), np.uint64)

    def __bool__(self) -> bool:
        return bool(self._crowds)

    def begin(self, core: _core.WorldBatch, environments: Sequence[int], seeds: IntArray) -> None:
        """Begins the random numbers of environments with their seeds (n,), after a reset."""
        mask = np.zeros(len(self._seeds), bool)
        mask[environments] = True
        for k in np.flatnonzero(mask & (self._seeds != seeds)).tolist():
            for row, (owner, name, _) in zip(self._keys, self._crowds):
                row[k] = plugin_rng(int(seeds[k]), owner, name).integers(2**63)
        self._seeds[mask] = seeds[mask]
        for row, (_, _, crowd) in zip(self._keys, self._crowds):
            core.seed_crowd(crowd, row, mask)
