"""The effects of plugins in a batch: worlds that they change at random, bodies that they move."""

from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np

from flatland2d.batch.motions import BatchMotions
from flatland2d.batch.randomness import BatchRandomness
from flatland2d.batch.robot import PluginRole, require_unchanged_footprints
from flatland_server import _core
from flatland_server.arrays import BoolArray, FloatArray, IntArray, Segments
from flatland_server.exceptions import UsageError
from flatland_server.simulation import World, WorldConfig, WorldState


class BatchWorlds:
    """Loads a world for each environment, with its seed, where worlds differ by their seeds.

    Args:
        roles: of the plugins of the world, which is shared unless one varies by the seed.
        count: number of environments, n.
        open: returns the world of a seed.
        is_random: whether the world's files depend on the seed.
    """

    def __init__(
        self,
        roles: Sequence[PluginRole],
        count: int,
        open: Callable[[int], World],
        is_random: bool,
    ) -> None:
        self._differ = is_random or any(each.role.varies_by_seed for each in roles)
        self._open = open
        self._last: Optional[World] = None
        self._loaded = np.full(count, -1, np.int64)
        """The seed with which the world of each environment was loaded."""
        self._walls: Dict[int, List[Segments]] = {}

    def __bool__(self) -> bool:
        """True if environments have worlds of their own."""
        return self._differ

    def load(self, core: _core.WorldBatch, chosen: BoolArray, seeds: IntArray) -> BoolArray:
        """Reloads the worlds of chosen environments after a change of their seed.

        Returns:
            The mask of environments with a new world, which has made no step.
        """
        is_other: BoolArray = chosen & (self._loaded != seeds)
        for k in np.flatnonzero(is_other).tolist():
            world = self._load(int(seeds[k]))
            core.replace(k, world.physics)
            self._walls[k] = [layer.segments for layer in world.layers]
            self._loaded[k] = seeds[k]
        return is_other

    def walls(self, environment: int) -> Optional[List[Segments]]:
        """The walls of each layer of an environment with a world of its own."""
        return self._walls.get(environment)

    def close(self) -> None:
        """Closes the world that was loaded last."""
        if self._last is not None:
            self._last.close()

    def _load(self, seed: int) -> World:
        if self._last is None:
            self._last = self._open(seed)
        else:
            self._last.reset(seed)
        require_unchanged_footprints(self._last)
        return self._last


class BatchPlugins:
    """The plugins of a batch that change its worlds.

    Args:
        config: contents of the initial world's files.
        roles: roles of the plugins, in the order in which a step calls them.
        count: number of environments, n.
        step_nanoseconds: length of a step [ns].
        open: returns the world of a seed.
        origin: the state in which environments begin; None: that of the world's files.
        scattered: see `BatchRandomness`.

    Attributes:
        worlds: those of environments, where they differ.
        motions: of bodies that plugins move.
        own_walls: of environments with other walls in the first layer than the world's.
    """

    def __init__(
        self,
        config: WorldConfig,
        roles: Sequence[PluginRole],
        count: int,
        step_nanoseconds: int,
        open: Callable[[int], World],
        origin: Optional[WorldState] = None,
        scattered: Optional[PluginRole] = None,
    ) -> None:
        self._config = config
        self._count = count
        self._step = step_nanoseconds
        self._origin = origin
        is_random = config.with_seed is not None and not origin
        self.worlds = BatchWorlds([] if origin else roles, count, open, is_random)
        self._randomness = BatchRandomness([] if origin else roles, count, scattered)
        self.motions = BatchMotions(roles, count, step_nanoseconds)
        self.own_walls: Dict[int, Optional[_core.Walls]] = {}

    def load(
        self,
        core: _core.WorldBatch,
        chosen: Optional[BoolArray],
        seeds: IntArray,
        steps: IntArray,
    ) -> None:
        """Loads the worlds of environments with new seeds, if worlds depend on the seed.

        Args:
            core: the batch in the core.
            chosen: which environments, (n,); None: all.
            seeds: of the environments, (n,).
            steps: made by each, (n,); set to 0 for environments that get another world.
        """
        if self.worlds:
            every = np.ones(self._count, bool)
            is_other = self.worlds.load(core, every if chosen is None else chosen, seeds)
            if is_other.any():
                steps[is_other] = 0
                self.begin(core, is_other, seeds)

    def reset(
        self,
        core: _core.WorldBatch,
        chosen: Optional[BoolArray],
        seeds: IntArray,
        poses: Optional[FloatArray],
        out: Tuple[Any, ...],
        model_poses: Optional[FloatArray],
    ) -> None:
        """Resets environments of the core, with their seeds (n,): see `WorldBatch.reset`.

        Raises:
            UsageError: people have found no places in an environment.
        """
        self._randomness.scatter(core, chosen, seeds)
        crowded = core.reset(chosen, poses, out, model_poses)
        if crowded >= 0:
            raise UsageError(
                f"environment {crowded}: expected room for all people in their area, found none "
                f"with the seed {seeds[crowded]}"
            )

    def begin(self, core: _core.WorldBatch, chosen: Optional[BoolArray], seeds: IntArray) -> None:
        """Begins environments that the core has reset, with their seeds (n,)."""
        if not self._randomness and not self.motions:
            return
        every = list(range(self._count)) if chosen is None else np.flatnonzero(chosen).tolist()
        self._randomness.begin(core, every, seeds)
        for k in every if self.motions else ():
            self.motions.begin(k, int(seeds[k]), self._walls(k))
            if self._origin is not None:
                self.motions.set_states(k, self._origin.plugins, self._origin.nanoseconds)

    def set_walls(self, core: _core.WorldBatch, walls: Mapping[int, Optional[_core.Walls]]) -> None:
        """Lets environments begin again with other walls in the first layer.

        Raises:
            UsageError: the world cannot have others. Nothing has changed.
        """
        if self.worlds and walls:
            raise UsageError("expected no walls for a world whose parts depend on the seed")
        try:
            for k, own in walls.items():
                core.set_walls(k, own)
        except ValueError as error:
            raise UsageError(f"the walls cannot be replaced: {error}") from None
        self.own_walls.update(walls)

    def _walls(self, environment: int) -> Optional[List[Segments]]:
        """The walls of each layer of an environment that has others than the world."""
        own = self.own_walls.get(environment)
        if own is None:
            return self.worlds.walls(environment)
        rest = self._config.layers[1:]
        return [own.segments, *(self._config.walls_of(layer) for layer in rest)]

    def restore(self, environment: int, state: WorldState) -> None:
        """Restores the states of those plugins that act, in an environment that the core has.

        Raises:
            StateError: they do not fit.
        """
        if self.motions:
            self.motions.begin(environment, state.seed, self._walls(environment))
            self.motions.set_states(environment, state.plugins, state.nanoseconds)

    def step(
        self,
        core: _core.WorldBatch,
        chosen: Optional[BoolArray],
        driven: Optional[BoolArray],
        commands: FloatArray,
        count: int,
        steps: IntArray,
        out: Tuple[Any, ...],
    ) -> None:
        """Makes steps, with the updates of plugins between them.

        Args:
            core: the batch in the core.
            chosen: which environments are stepped, (n,); None: all.
            driven: which robots are driven in them and observed, as in `core.step`.
            commands: actions of all robots.
            count: number of steps.
            steps: that each environment has made before, (n,).
            out: arrays that the core writes to.
        """
        made, step_size = 0, self._step * 1e-9
        if self.motions:
            core.require_actions(commands, driven)  # before anything is moved
        while self.motions:
            now = self.motions.update(core, chosen, (steps + made) * self._step, count - made)
            if now == count - made:
                break
            core.step(commands, now, step_size, None, goes_on=made > 0, mask=driven)
            made += now
        core.step(commands, count - made, step_size, out, goes_on=made > 0, mask=driven)

    def added_walls(self, environment: int) -> FloatArray:
        """Walls that plugins have added to an environment: (m, 4)."""
        if not self.worlds:
            return np.empty((0, 4))
        counts = [len(self._config.walls_of(layer)) for layer in self._config.layers]
        walls = self.worlds.walls(environment) or []
        added = [segments[count:] for segments, count in zip(walls, counts)]
        return np.concatenate([np.empty((0, 4)), *added])
