"""Many environments in one call, without ROS: `SimulationBatch("office", 1024).step(actions)`."""

import os
from dataclasses import replace
from typing import Any, Callable, Dict, List, Mapping, NoReturn, Optional, Sequence, Tuple, Union

import numpy as np

from flatland2d.batch.arguments import (
    actions_of,
    index_of,
    mask_of,
    poses_of,
    require_index,
    seeds_of,
    states_of,
    steps_of,
    walls_of,
)
from flatland2d.batch.free_spaces import free_space_of
from flatland2d.batch.noise import BatchNoises
from flatland2d.batch.observation import BatchObservation
from flatland2d.batch.plugins import BatchPlugins
from flatland2d.batch.randomness import as_before_scatter, find_scattered
from flatland2d.batch.robot import (
    make_core,
    require_alike,
    require_unchanged_footprints,
    roles_of,
)
from flatland2d.batch.variation import Variation, ranges_of
from flatland2d.batch.view import BatchView
from flatland2d.free_space import FreeSpace
from flatland2d.robot import Robot, find_robot
from flatland2d.simulation import Simulation
from flatland2d.world_source import WorldSource, open_world
from flatland_server import _core
from flatland_server._core import Walls
from flatland_server.arguments import (
    folders_of,
    params_of,
    several,
    shown,
    whole_number,
)
from flatland_server.arrays import ArrayLike, BoolArray, FloatArray, IntArray
from flatland_server.exceptions import StateError, UsageError
from flatland_server.plugins import PluginLoader
from flatland_server.simulation import World, WorldConfig, WorldState, saved_states
from flatland_server.timekeeper import Timekeeper
from flatland_server.transport import LocalTransport

_MOST_STEPS = 2**31 - 1
_SHOWN = 9
"""The number of environments in the picture of a notebook."""


class SimulationBatch:
    """Environments with the same initial world, stepped in one C++ call, with a robot or several.

        with SimulationBatch("office", 1024, threads=2) as batch:
            actions = np.zeros((1024, 2))                # m/s and rad/s of a DiffDrive
            observation = batch.step(actions, substeps=20)
            observation.ranges, observation.poses, observation.collided
            observation = batch.reset(observation.collided)

    An environment has the same poses, velocities and ranges, bit for bit, as a `Simulation` of the
    same world and seed, for any number of environments and threads, and independent of the other
    environments. Robots of different environments do not see each other.

    Python runs no hooks of plugins: the core drives, steps and scans. Drives, lidars, tweens and
    crowds work, and plugins that only observe are left out. Those that set velocities of bodies at
    their updates do so in all environments at once (`BatchMotion`). The lidar has its noise; poses
    and velocities are the true ones, whatever the noise of odometry.

    The arrays of an observation are new ones in each call, unless the caller passes some as `out`.
    The batch keeps no reference to them and never writes to them later. A batch is used by one
    thread at a time; `step` and `reset` release the GIL.

    Args:
        world: the name of a shipped world such as "office", the path of a world file, or the
            content of one as a dict.
        num_envs: number of environments, n.
        robot: name of the model that is commanded and observed; None: the only one with a drive and
            a lidar.
        robots: instead, the names of m such models in each environment, with equal actions and
            beams. Arrays of robots then have the shape (n, m, ...) instead of (n, ...).
        lidar: name of the plugin that is read; None: the robot's only lidar.
        threads: number of threads; each steps an equal part of the environments.
        moved: names of other models that `reset` can move.
        vary: numbers of model files that `reset` can set in each environment: the least and the
            greatest value of each, by names as "turtlebot/laser/range": a model, its plugin or
            body, and keys. Until a reset, environments have the greatest values.
        step_size: length of a step [s].
        seed: of environment 0; environment k has `seed + k`. Or a seed for each environment.
        params: parameters by absolute name, for expressions in the files and for plugins.
        simplify_map: how much the outlines of map images are simplified: 0 not at all, 1 or 2.
        model_folders: where model files are looked up that are not beside the world file.
        loader: finds plugin classes; by default those that installed packages declare.
        state: of a `Simulation` or an environment of the same world, in which all environments
            begin, with its seed; None: they begin as the world's files say.

    Raises:
        FlatlandError: there is no such world, something in its files is wrong, it has no such robot
            or lidar, or a plugin that acts by itself (`Plugin.batch_role`); or the state does not
            fit.
    """

    def __init__(
        self,
        world: WorldSource,
        num_envs: int,
        *,
        robot: Optional[str] = None,
        robots: Optional[Sequence[str]] = None,
        lidar: Optional[str] = None,
        threads: int = 1,
        moved: Sequence[str] = (),
        vary: Mapping[str, Tuple[float, float]] = {},
        step_size: float = 0.005,
        seed: Union[int, Sequence[int], IntArray] = 0,
        params: Mapping[str, Any] = {},
        simplify_map: int = 0,
        model_folders: Sequence[Union[str, "os.PathLike[str]"]] = (),
        loader: Optional[PluginLoader] = None,
        state: Optional[bytes] = None,
    ) -> None:
        self._num_envs = whole_number(num_envs, "a number of environments", 1)
        self._threads = whole_number(threads, "a number of threads", 1)
        self._step_nanoseconds = Timekeeper(step_size).step_nanoseconds
        origin = None if state is None else WorldState.loads(state)
        first_step = 0 if origin is None else steps_of(origin, self._step_nanoseconds)
        seeds = seed if origin is None else np.full(self._num_envs, origin.seed)
        self._seeds = seeds_of(seeds, self._num_envs)
        self._params, self._loader = params_of(params), loader
        self._world = open_world(
            world,
            LocalTransport(self._params, ()),
            seed=int(self._seeds[0]),
            simplify_map=simplify_map,
            model_folders=folders_of(model_folders),
            loader=loader,
        )
        require_unchanged_footprints(self._world)
        if robot is not None and robots is not None:
            raise UsageError(f"expected robot or robots, found both: {shown((robot, robots))}")
        names = [robot] if robots is None else several(robots, "robots")

        def robots_of(world: World) -> List[Robot]:
            return [find_robot(world, name, lidar) for name in names]

        if vary and origin is not None:
            raise UsageError("expected no vary for a batch that begins in a state")
        self._variation = Variation(
            self._world.config, ranges_of(vary), self._num_envs, self._load, robots_of
        )
        if self._variation:
            self._world.close()
            self._world = self._load(self._variation.config)
        if origin is not None:  # its changed footprints are those of all environments
            saved_states.restore(origin, self._world)
        roles, scattered = roles_of(self._world), None
        if origin is None:
            roles, scattered = find_scattered(self._world, roles)
        self._robots = robots_of(self._world)
        require_alike(self._robots)
        self._robot = self._robots[0]
        self._team = None if robots is None else len(self._robots)  # m of the arrays' shapes
        self._shape = (self._num_envs,) if self._team is None else (self._num_envs, self._team)
        self._view = BatchView(self._world, self.step_size, self._params, loader, state)
        self._moved = [self._world.get_model(name) for name in several(moved, "moved")]
        for each in self._robots:
            if each.model in self._moved:
                raise UsageError(
                    f'expected other models as moved, found the robot "{each.model.name}"'
                )
        self._action_names = self._robot.action_names
        with as_before_scatter(self._world, scattered):
            core = make_core(
                self._world,
                self._robots,
                self._num_envs,
                threads=self._threads,
                moved=self._moved,
                steps=first_step,
                varied=self._variation.settings,
            )
        self._core: Optional[_core.WorldBatch] = core
        self._beams = core.beams
        self._steps = np.full(self._num_envs, first_step, np.int64)
        self._parts: Optional[WorldState] = None
        self._plugins = BatchPlugins(
            self._world.config,
            roles,
            self._num_envs,
            self._step_nanoseconds,
            self._open,
            origin,
            scattered,
        )
        if scattered is not None:
            arrays = self._arrays(self._rows(None))
            self._plugins.reset(core, None, self._seeds, None, arrays, None)
        self._plugins.begin(core, None, self._seeds)
        varies = self._world.config.with_seed or any(each.role.varies_by_seed for each in roles)
        self._only_seed = origin.seed if origin is not None and varies else None
        self._noise = BatchNoises(self._robots, self._num_envs, self._variation.noises)
        self._spaces: Dict[float, FreeSpace] = {}

    # Facts

    @property
    def num_envs(self) -> int:
        """The number of environments, n."""
        return self._num_envs

    @property
    def threads(self) -> int:
        """The number of threads."""
        return self._threads

    @property
    def worlds_differ(self) -> bool:
        """True if environments have worlds of their own, as with a RandomWall."""
        return bool(self._plugins.worlds)

    @property
    def step_size(self) -> float:
        """Length of a step [s]."""
        return self._step_nanoseconds * 1e-9

    @property
    def seeds(self) -> IntArray:
        """The seeds of the environments: a new array (n,)."""
        return self._seeds.copy()

    @property
    def robot(self) -> str:
        """The name of the model that is commanded and observed; with `robots`, of the first."""
        return self._robot.model.name

    @property
    def robots(self) -> Tuple[str, ...]:
        """The names of all models that are commanded and observed."""
        return tuple(each.model.name for each in self._robots)

    @property
    def beams(self) -> int:
        """The number of beams of the lidar."""
        return self._beams

    @property
    def max_range(self) -> float:
        """The largest distance that the lidar measures [m]."""
        return self._robot.core_lidar.range

    @property
    def action_names(self) -> Tuple[str, ...]:
        """The names of an action's numbers: the parameters of the drive's `command`."""
        return self._action_names

    @property
    def action_limits(self) -> FloatArray:
        """The least and the greatest value of each number of an action: a new array (2, k).

        Infinite if the drive has no limit. The drive obeys a command beyond them as far as it can.
        """
        limits = np.array([limit or np.inf for limit in self._robot.core_drive.limits])
        return np.stack([-limits, limits])

    # Steps

    def step(
        self,
        actions: ArrayLike,
        substeps: int = 1,
        out: Optional[BatchObservation] = None,
        mask: Optional[ArrayLike] = None,
    ) -> BatchObservation:
        """Commands robots, makes steps in their environments, and observes.

        Args:
            actions: shape (n, k), or (n, m, k) with `robots`, of float32 or float64: a row for each
                robot, as a `Simulation` would pass to `command`.
            substeps: number of steps, during which the commands hold.
            out: arrays that the observation is written to: only the rows of those environments that
                are stepped, or of the mask's robots. By default new arrays, with all rows.
            mask: shape (n,), bool: which environments; None: all. The others stay as they are,
                whatever their actions, which may be NaN. A mask of only False changes nothing.
                With `robots`, also of shape (n, m): the other robots of an environment with a True
                are commanded to stop.

        Returns:
            `out`, or new arrays.

        Raises:
            UsageError: the actions are no finite numbers of this shape, the mask or `out` does not
                fit, or the batch is closed. Nothing has changed.
        """
        core = self._require_open()
        chosen, driven = self._masks(mask)
        size = len(self._action_names)
        commands = actions_of(actions, (*self._shape, size), self._action_names)
        commands = commands.reshape(-1, size)
        substeps = whole_number(substeps, "a number of steps", 1)
        if substeps > _MOST_STEPS:
            raise UsageError(f"expected at most {_MOST_STEPS} steps, found {shown(substeps)}")
        observation = self._rows(out)
        arrays = self._arrays(observation)
        self._plugins.load(core, chosen, self._seeds, self._steps)
        try:
            self._plugins.step(core, chosen, driven, commands, substeps, self._steps, arrays)
        except ValueError as error:  # an action is not finite
            raise UsageError(str(error)) from None
        self._finish(observation, chosen, driven, is_new=out is None)
        return observation

    def stepper(self, substeps: int, out: BatchObservation) -> Callable[[FloatArray], None]:
        """A function that does what `step` does with all robots, without its checks.

        A step of one environment takes the core as long as these checks take Python.

        Args:
            substeps: as for `step`.
            out: arrays that each call writes to, except for the times.

        Returns:
            A function of finite commands, shape (robots of all environments, k) of float64.

        Raises:
            UsageError: `out` does not fit, or the batch is closed.
        """
        core, plugins = self._require_open(), self._plugins
        arrays = self._arrays(self._rows(out))

        def step(commands: FloatArray) -> None:
            plugins.load(core, None, self._seeds, self._steps)
            plugins.step(core, None, None, commands, substeps, self._steps, arrays)
            self._add_noise(out, None)

        return step

    def restarter(
        self, out: BatchObservation
    ) -> Callable[[IntArray, FloatArray, Optional[FloatArray]], None]:
        """A function that does what `reset` does with all environments, without its checks.

        Args:
            out: as for `stepper`.

        Returns:
            A function of seeds (n,), the poses of all robots (n * m, 3), and those of the models of
            `moved` (n, 3 * models), or None.

        Raises:
            UsageError: `out` does not fit, or the batch is closed.
        """
        core, plugins = self._require_open(), self._plugins
        arrays = self._arrays(self._rows(out))

        def restart(seeds: IntArray, poses: FloatArray, model_poses: Optional[FloatArray]) -> None:
            plugins.load(core, None, seeds, self._steps)
            plugins.reset(core, None, seeds, poses, arrays, model_poses)
            self._seeds[:] = seeds
            plugins.begin(core, None, self._seeds)
            self._noise.restart(range(self._num_envs))
            self._add_noise(out, None)

        return restart

    def reset(
        self,
        mask: Optional[ArrayLike] = None,
        seeds: Union[int, Sequence[int], IntArray, None] = None,
        poses: Optional[ArrayLike] = None,
        out: Optional[BatchObservation] = None,
        model_poses: Optional[ArrayLike] = None,
        walls: Mapping[int, Optional[Walls]] = {},
        vary: Mapping[str, ArrayLike] = {},
    ) -> BatchObservation:
        """Puts environments back to the beginning of the world, at time 0, and observes.

        Args:
            mask: shape (n,), bool: which environments; None: all.
            seeds: as for the class, from now on; None: as before. Only those of environments that
                are reset count.
            poses: shape (n, 3), or (n, m, 3) with `robots`: where they are put, x, y [m] and yaw
                [rad], as by `Simulation.move`; None: as in the world file. Only those of
                environments that are reset count; see `free_poses`.
            out: arrays that the observation is written to: only the rows of those environments that
                are reset. By default new arrays, with all rows.
            model_poses: shape (n, m, 3): where the m models of `moved` are put after that; None: as
                in the world file.
            walls: maps of environments that are reset, by their indices: from now on, these walls
                are in the place of those of the world's first layer; None: those of the world. Many
                environments may have the same one.
            vary: numbers of the class's `vary` that they have from now on, by name: one for all, or
                one for each environment, shape (n,). Only those of environments that are reset
                count; others of their numbers stay.

        Returns:
            `out`, or new arrays.

        Raises:
            UsageError: an argument has a wrong shape or value, the world has no layer, or
                environments begin in a state near walls, or the batch is closed. Nothing has
                changed.
        """
        core = self._require_open()
        chosen = None if mask is None else mask_of(mask, self._num_envs)
        placed = None if poses is None else poses_of(poses, "poses", self._shape, chosen)
        others = None
        if model_poses is not None:
            rows = (self._num_envs, len(self._moved))
            others = poses_of(model_poses, "model_poses", rows, chosen)
            others = others.reshape(self._num_envs, -1) if self._moved else None
        new_seeds = None if seeds is None else seeds_of(seeds, self._num_envs)
        observation = self._rows(out)
        seeds_now = self._seeds if new_seeds is None else new_seeds
        own_walls = walls_of(walls, self._num_envs, chosen)
        former = self._variation.set(core, vary, chosen) if vary else None
        try:
            self._plugins.set_walls(core, own_walls)
        except UsageError:
            if former is not None:
                self._variation.put(core, former)
            raise
        self._plugins.load(core, chosen, seeds_now, self._steps)
        self._plugins.reset(core, chosen, seeds_now, placed, self._arrays(observation), others)
        self._change_seeds(new_seeds, chosen)
        self._plugins.begin(core, chosen, self._seeds)
        self._finish(observation, *self._masks(chosen), is_new=out is None)
        return observation

    def move(self, poses: ArrayLike, mask: Optional[ArrayLike] = None) -> None:
        """Puts robots elsewhere, at rest, as `Simulation.move` does.

        Args:
            poses: as for `reset`; only those of the mask count.
            mask: as for `step`: which environments, or which of their robots; None: all.

        Raises:
            UsageError: an argument has a wrong shape or value, or the batch is closed. Nothing has
                changed.
        """
        core = self._require_open()
        chosen, driven = self._masks(mask)
        rows = None if driven is None else driven.reshape(self._shape)
        placed = poses_of(poses, "poses", self._shape, rows)
        self._plugins.load(core, chosen, self._seeds, self._steps)
        core.move_robots(placed, driven)

    def observe(self, out: Optional[BatchObservation] = None) -> BatchObservation:
        """Observes all environments as they are.

        Args:
            out: arrays that the observation is written to; by default new ones.

        Raises:
            UsageError: `out` does not fit, or the batch is closed.
        """
        self._require_open()
        observation = self._rows(out)
        self._observe(observation)
        return observation

    def view(self, index: int) -> Simulation:
        """A simulation that shows the present state of an environment, for pictures.

            batch.view(3).save_picture("robot.png", follow=batch.robot, sensors=True)

        It has the environment's seed, time, poses and velocities, but no other state, such as that
        of contacts: stepping it does not continue the run of the environment. The yaw of a body
        that has turned by more than half a turn is rounded (by at most 5e-7 rad). All calls return
        the same simulation, and the batch closes it.

        Args:
            index: index of the environment, from 0.

        Raises:
            UsageError: there is no such environment, or the batch is closed.
        """
        core, chosen = self._load_one(index)
        poses, velocities = core.motions(self._view.bodies, chosen)
        nanoseconds = int(self._steps[index]) * self._step_nanoseconds
        seed = int(self._seeds[index])
        own, values = self._plugins.own_walls.get(index), self._variation.of(index)

        def config() -> WorldConfig:
            found = self._variation.config_of(index) if values else self._world.config
            return found if own is None else found.with_walls(own.segments)

        motions = poses[index], velocities[index]
        return self._view.show(seed, nanoseconds, *motions, (own, values), config)

    @property
    def models(self) -> Tuple[str, ...]:
        """The names of all models in the world, also of the robot."""
        return tuple(self._world.models)

    def model_motions(self) -> Tuple[FloatArray, FloatArray]:
        """The poses and velocities of all models, in the order of `models`: new arrays (n, m, 3).

        x, y [m] and yaw [rad] of each model's first body, and its vx, vy [m/s] and omega [rad/s],
        in the world's frame.

        Raises:
            UsageError: the batch is closed.
        """
        core = self._require_open()
        self._plugins.load(core, None, self._seeds, self._steps)
        bodies = [model.base.physics_body for model in self._world.models.values()]
        return core.motions(bodies, None)

    def _repr_png_(self) -> bytes:
        """The picture that a notebook shows of a batch: its first environments."""
        from flatland2d.rendering.film import side_by_side

        shown = range(min(self._num_envs, _SHOWN))
        return side_by_side(
            [self.view(index).render((240, 180), follow=self.robot) for index in shown]
        )

    # States

    def save_states(self, mask: Optional[ArrayLike] = None) -> List[bytes]:
        """The states of environments, for `load_states` here or in another process.

        A `Simulation` of the same world loads them, too; plugins that a batch leaves out begin
        there from scratch.

        Args:
            mask: shape (n,), bool: which environments; None: all.

        Returns:
            A state for each of them, in their order.

        Raises:
            StateError: a plugin's state cannot be saved.
            UsageError: the mask does not fit, or the batch is closed.
        """
        core = self._require_open()
        chosen = None if mask is None else mask_of(mask, self._num_envs)
        self._plugins.load(core, chosen, self._seeds, self._steps)
        parts, every = self._own_parts(), range(self._num_envs)
        own = {k: each.segments for k, each in self._plugins.own_walls.items() if each is not None}
        return [
            replace(
                parts,
                seed=int(self._seeds[k]),
                nanoseconds=int(self._steps[k]) * self._step_nanoseconds,
                plugins=self._plugins.motions.states(k),
                physics=core.save_state(k),
                own_walls=own.get(k),
                vary=self._variation.of(k),
                is_of_batch=True,
            ).dumps()
            for k in (every if chosen is None else np.flatnonzero(chosen).tolist())
        ]

    def load_states(
        self,
        states: Union[bytes, Sequence[bytes]],
        mask: Optional[ArrayLike] = None,
        out: Optional[BatchObservation] = None,
    ) -> BatchObservation:
        """Puts environments into saved states, their times and seeds included, and observes.

        Each goes on as a `Simulation` does that loads the state, bit for bit.

        Args:
            states: of `save_states`, or of a `Simulation` of the same world: one for all
                environments, or one for each, in their order.
            mask: shape (n,), bool: which environments; None: all.
            out: arrays that the observation is written to: only the rows of these environments. By
                default new arrays, with all rows.

        Returns:
            `out`, or new arrays.

        Raises:
            StateError: a state is damaged or does not fit.
            UsageError: an argument has a wrong shape or type, or the batch is closed. Nothing has
                changed.
        """
        core = self._require_open()
        chosen = None if mask is None else mask_of(mask, self._num_envs)
        every = np.arange(self._num_envs)
        indices = every if chosen is None else np.flatnonzero(chosen)
        observation = self._rows(out)
        given = states_of(states, len(indices))
        saved = {each: WorldState.loads(each) for each in dict.fromkeys(given)}
        for state in saved.values():
            self._require_loadable(state)
        number = {each: index for index, each in enumerate(saved)}
        seeds, steps = self._seeds.copy(), self._steps.copy()
        numbers = np.zeros(self._num_envs, np.int64)
        numbers[indices] = [number[each] for each in given]
        steps[indices] = [steps_of(saved[each], self._step_nanoseconds) for each in given]
        seeds[indices] = [saved[each].seed for each in given]
        self._plugins.load(core, chosen, seeds, self._steps)
        physics, arrays = [each.physics for each in saved.values()], self._arrays(observation)
        former = self._variation.take(core, indices, [saved[each].vary for each in given])
        try:
            walls = [None if s.own_walls is None else Walls(s.own_walls) for s in saved.values()]
            core.load_states(chosen, physics, walls, numbers, steps, arrays)
        except ValueError as error:
            self._variation.put(core, former)
            raise StateError(f"the state cannot be loaded: {error}") from None
        self._plugins.own_walls.update((k, walls[numbers[k]]) for k in indices.tolist())
        self._noise.restart(np.flatnonzero(seeds != self._seeds).tolist())
        self._seeds = seeds
        for k, each in zip(indices.tolist(), given):
            self._plugins.restore(k, saved[each])
        self._finish(observation, *self._masks(chosen), is_new=out is None)
        return observation

    def _require_loadable(self, state: WorldState) -> None:
        """Checks all of a state but its numbers.

        Raises:
            StateError: the batch's world has other models, walls or footprints.
        """
        saved_states.require_same_parts(state, self._own_parts(), self._world.config)
        if self._only_seed not in (None, state.seed):
            raise StateError(
                f"expected a state with the seed {self._only_seed}, on which the walls of the "
                f"batch depend, found {state.seed}"
            )

    def _own_parts(self) -> WorldState:
        """The models, walls and footprints of all environments, as a part of a state."""
        if self._parts is None:
            self._parts = saved_states.parts_of(self._world)
        return self._parts

    # Places

    def added_walls(self, index: int) -> FloatArray:
        """Walls that plugins have added to an environment: a new array (m, 4), x1, y1, x2, y2 [m].

        Args:
            index: index of the environment, from 0.

        Raises:
            UsageError: there is no such environment, or the batch is closed.
        """
        if self._plugins.worlds:
            self._load_one(index)
        else:
            self._require_open()
            require_index(index, self._num_envs)
        return self._plugins.added_walls(index)

    def free_space(self, clearance: float) -> FreeSpace:
        """The free space for initial poses of the robot; computed once for each clearance.

        Args:
            clearance: distance [m] of the robot's origin from all walls that it collides with, and
                from the circles around all other models; but not from `added_walls`.

        Raises:
            UsageError: the clearance is not usable, or leaves no place.
        """
        return free_space_of(self._world, self._robots, clearance, self._spaces)

    def free_poses(self, count: int, clearance: float, rng: np.random.Generator) -> FloatArray:
        """Random poses for `reset`, uniformly distributed over `free_space` and all headings.

        They are independent of each other: two may overlap.

        Args:
            count: number of poses.
            clearance: as for `free_space`.
            rng: generator of NumPy to draw from.

        Returns:
            Shape (count, 3): x, y [m] and yaw [rad] of the robot's origin.
        """
        return self.free_space(clearance).poses(count, rng)

    # Its end

    def close(self) -> None:
        """Frees all environments. Later calls raise a UsageError, except for the facts above."""
        if self._core is not None:
            self._core = None
            self._world.close()
            self._plugins.worlds.close()
            self._view.close()

    def __enter__(self) -> "SimulationBatch":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __reduce__(self) -> NoReturn:
        raise UsageError("a SimulationBatch is neither copied nor pickled: see save_states")

    def _require_open(self) -> _core.WorldBatch:
        if self._core is None:
            raise UsageError("the batch is closed")
        return self._core

    def _load_one(self, index: int) -> Tuple[_core.WorldBatch, BoolArray]:
        """Loads one environment's world; returns the core and the environment's mask.

        Raises:
            UsageError: there is no such environment, or the batch is closed.
        """
        core, chosen = self._require_open(), index_of(index, self._num_envs)
        self._plugins.load(core, chosen, self._seeds, self._steps)
        return core, chosen

    def _open(self, seed: int) -> World:
        """The world with another seed."""
        return self._load(self._world.config, seed)

    def _load(self, config: WorldConfig, seed: Optional[int] = None) -> World:
        """A world; with the seed of environment 0, unless another one is given."""
        own = int(self._seeds[0]) if seed is None else seed
        return World(config, LocalTransport(self._params, ()), seed=own, loader=self._loader)

    def _rows(self, out: Optional[BatchObservation]) -> BatchObservation:
        if out is None:
            return BatchObservation.empty(self._num_envs, self._beams, self._team)
        if not isinstance(out, BatchObservation):
            raise UsageError(f"expected a BatchObservation as out, found {shown(out)}")
        out.check(self._num_envs, self._beams, self._team)
        return out

    def _arrays(self, rows: BatchObservation) -> Tuple[Any, ...]:
        """The arrays that the core writes to, which have a row for each robot."""
        if self._team is None:
            return (*rows[:5], self._steps)
        size = self._num_envs * self._team
        return (*(each.reshape(size, *each.shape[2:]) for each in rows[:5]), self._steps)

    def _masks(self, mask: Any) -> Tuple[Optional[BoolArray], Optional[BoolArray]]:
        """The environments of a mask that a program has passed, (n,), and all robots of it."""
        if mask is None:
            return None, None
        found = mask_of(mask, self._num_envs, self._team)
        if self._team is None:
            return found, found
        if found.ndim == 1:
            return found, np.repeat(found, self._team)
        return found.any(axis=1), found.ravel()

    def _observe(self, rows: BatchObservation) -> None:
        """Writes the rows of all environments."""
        core = self._require_open()
        self._plugins.load(core, None, self._seeds, self._steps)
        core.observe(self._arrays(rows))
        self._finish(rows, None, None)

    def _finish(
        self,
        rows: BatchObservation,
        mask: Optional[BoolArray],
        driven: Optional[BoolArray],
        is_new: bool = False,
    ) -> None:
        """Completes the rows of environments and robots in the masks, which the core has written.

        Writes their times, and adds noise. In new arrays, writes all other rows, too.
        """
        if is_new and driven is not None and not driven.all():
            self._observe(rows)
            return
        where = True if mask is None else mask
        np.multiply(self._steps * self._step_nanoseconds, 1e-9, out=rows.times, where=where)
        self._add_noise(rows, driven)

    def _add_noise(self, rows: BatchObservation, driven: Optional[BoolArray]) -> None:
        if self._noise:
            nanoseconds = self._steps * self._step_nanoseconds
            self._noise.add(rows.ranges, self._seeds, nanoseconds, driven)

    def _change_seeds(self, seeds: Optional[IntArray], mask: Optional[BoolArray]) -> None:
        if seeds is None:
            return
        chosen = np.arange(self._num_envs) if mask is None else np.flatnonzero(mask)
        self._seeds[chosen] = seeds[chosen]
        self._noise.restart(chosen.tolist())
