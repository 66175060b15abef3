"""The other models that robots observe: those within reach that no wall hides, with noise."""

from typing import Dict, Optional, Sequence

import numpy as np

from flatland_gym.maps import Maps
from flatland_gym.navigation_world import NavigationWorld
from flatland_gym.observations import neighbor_rows
from flatland_gym.settings import NavigationSettings
from flatland_server import Float32Array, FloatArray, IntArray, Segments
from flatland_server._core import LinesOfSight, blocked_lines, normal_rows

# Large odd numbers, so that seeds, robots and steps have noise of their own.
_SEED, _ROBOT, _STEP = (
    np.uint64(each) for each in (0x9E3779B97F4A7C15, 0xD1B54A32D192ED03, 0x8CB92BA72F3D8DD7)
)


class Neighbors:
    """Observations of other models, for n robots.

    Args:
        worlds: the environments' worlds.
        settings: the environments' settings.
        count: number of robots, n.
        team: number of robots in each environment.
        maps: the maps of `settings`.

    Attributes:
        seeds: of the present episodes, shape (n,).
        reach: the largest gap at which a model is observed [m].
    """

    def __init__(
        self,
        worlds: Sequence[NavigationWorld],
        settings: NavigationSettings,
        count: int,
        team: int,
        maps: Optional[Maps],
    ) -> None:
        self._count, self._noise = settings.neighbors, float(settings.neighbor_noise)
        self.reach = float(settings.neighbor_range or worlds[0].robot.max_range)
        sees_all = settings.neighbors_behind_walls
        self._walls = [LinesOfSight(np.empty((0, 4)) if sees_all else w.walls) for w in worlds]
        self._maps = None if sees_all else maps
        self._added: Dict[int, LinesOfSight] = {}
        self.seeds = np.zeros(count, np.uint64)
        self._robots = np.arange(count, dtype=np.uint64) % np.uint64(team) * _ROBOT

    def add_walls(self, rows: Sequence[int], walls: Segments) -> None:
        """Tells the walls that plugins have added to the environment of robots with these rows."""
        for row in rows:
            self._added.pop(row, None)
            if len(walls):
                self._added[row] = LinesOfSight(walls)

    def observe(
        self,
        poses: FloatArray,
        velocities: FloatArray,
        others: FloatArray,
        places: IntArray,
        steps: IntArray,
    ) -> Float32Array:
        """As `neighbor_rows`.

        Args:
            poses: as for `neighbor_rows`.
            velocities: as for `neighbor_rows`.
            others: as for `neighbor_rows`; changed.
            places: the indices of the robots' worlds, or the numbers of their maps, shape (n,).
            steps: of the episodes so far, shape (n,).
        """
        offsets = others[..., :2] - poses[:, None, :2]
        near = np.hypot(offsets[..., 0], offsets[..., 1]) - others[..., 4] <= self.reach
        rows, columns = np.nonzero(near)
        lines = np.concatenate([poses[rows, :2], others[rows, columns, :2]], axis=1)
        if self._maps is not None:
            numbers, which = np.unique(places[rows], return_inverse=True)
            hidden = blocked_lines([self._maps[k].lines for k in numbers.tolist()], which, lines)
        elif len(self._walls) == 1:
            hidden = self._walls[0].blocked(lines)
        else:
            hidden = blocked_lines(self._walls, places[rows], lines)
        if self._added:
            number = np.full(len(poses), -1)
            number[list(self._added)] = range(len(self._added))
            hidden |= blocked_lines(list(self._added.values()), number[rows], lines)
        others[rows[hidden], columns[hidden]] = np.nan
        if self._noise:
            keys = self.seeds * _SEED + self._robots + steps.astype(np.uint64) * _STEP
            numbers = normal_rows(keys, 4 * others.shape[1])
            others[..., :4] += self._noise * numbers.reshape(*others.shape[:2], 4)
        return neighbor_rows(poses, velocities, others, self._count, self.reach)
