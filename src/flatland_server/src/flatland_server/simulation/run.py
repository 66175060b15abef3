"""A world and its time: steps, resets, and saved states."""

from typing import Callable, List, Optional, Tuple, TypeVar

from flatland_server.arguments import whole_number
from flatland_server.exceptions import FlatlandError, PluginError, UsageError
from flatland_server.plugins.plugin_manager import PluginFailure
from flatland_server.simulation import saved_states
from flatland_server.simulation.world import World
from flatland_server.simulation.world_config import WorldConfig
from flatland_server.simulation.world_state import WorldState
from flatland_server.timekeeper import Timekeeper
from flatland_server.transport.transport import Transport

R = TypeVar("R", bound="Run")

_MAX_STEPS_PER_CALL = 100
"""Python handles signals, such as Ctrl-C, between two calls of the core."""


class Run:
    """A world that is stepped; time passes only in steps.

    `SimulationManager` steps it in real time, `Simulation` at the calls of a program.

    Args:
        world: world to step.
        timekeeper: counts the simulated time.
        raise_failures: whether the exception of a plugin ends the step with a PluginError;
            otherwise it is logged. In both cases the plugin is switched off.

    Attributes:
        world: the layers, models and plugins, and the physics.
        timekeeper: counts the simulated time.
        transport: the topics and transforms of the world.
        after_step: called after each step.
        after_jump: called after a reset, a reload or the loading of a state: the world's contents
            are new objects, and time may have jumped.
    """

    def __init__(
        self, world: World, timekeeper: Timekeeper, *, raise_failures: bool = False
    ) -> None:
        self.world = world
        self.timekeeper = timekeeper
        self.transport: Transport = world.transport
        self.after_step: List[Callable[[], None]] = []
        self.after_jump: List[Callable[[], None]] = []
        self._settled: float = -1  # the transport's activity before the last step, if known
        self._failures: List[Tuple[PluginFailure, BaseException]] = []
        self._is_closed = False
        if raise_failures:
            world.contents.plugins.on_failure = self._note_failure

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.timekeeper.seconds

    @property
    def step_size(self) -> float:
        """Length of a step [s]."""
        return self.timekeeper.step_size

    @property
    def seed(self) -> int:
        """The seed of all random numbers."""
        return self.world.seed

    # Steps

    def step(self: R, count: int = 1) -> R:
        """Advances the time by some steps, and returns this run.

        Messages that were sent are received before each of them.

        Args:
            count: number of steps, 1 or more.

        Raises:
            UsageError: the count is no whole number of 1 or more, or the simulation is closed.
            PluginError: a plugin has raised an exception, which is the `__cause__`. The step that
                it was raised in is complete, and those after it are not made.
            FlatlandError: this is called by a hook of a plugin.
        """
        if (
            self._settled == self.transport.activity
            and type(count) is int
            and count > 0
            and not self.after_step
            and self._step_as_planned(count)
        ):
            return self
        self.require_open()
        left = whole_number(count, "a number of steps", 1)
        while left > 0:
            self._settled = -1
            activity = self.transport.activity
            self.transport.process()
            if self.after_step:  # each step is followed by calls
                self._step_up_to(1)
                left -= 1
                for callback in list(self.after_step):
                    callback()
            else:
                left -= self._step_up_to(left)
                self._settled = activity
            if self._failures:
                self._raise_failures()
        return self

    def _step_up_to(self, limit: int) -> int:
        """Makes as many steps as are possible in one call of the core, and at least one.

        The same as this many single steps, also for the hooks of plugins. The call ends before a
        step in which a plugin is due, after one in which a contact hook was called, and after one
        that is followed by callbacks, so that `transport.process()` may be called between any two
        steps that affect each other.

        Args:
            limit: greatest number of steps, 1 or more.

        Returns:
            The number of steps made.
        """
        contents, transport = self.world.contents, self.transport
        deferred = contents.deferred
        if transport.has_to_deliver:
            limit = 1
        is_current = contents.plan.subscriber_revision == transport.subscriber_revision
        has_no_changes = not deferred.pending and not deferred.lock.depth
        if is_current and has_no_changes and self._step_as_planned(limit):
            transport.flush()
            return limit
        # A valid plan already tells whether a hook is to be called in the next step.
        if has_no_changes and deferred.defers_nothing and not (is_current and limit == 1):
            most = min(limit, _MAX_STEPS_PER_CALL)
            steps = contents.plugins.steps_without_hooks(self.timekeeper, most)
            if steps > 0:
                return self._step_until_contact(steps)
        self._step_with_hooks()
        return 1

    def _step_as_planned(self, count: int) -> bool:
        """Makes steps, 1 or more, if by the plan they call no hooks; in one call of the core.

        To be called only if there are no messages to deliver, and subscribers are those of the
        plan.

        Returns:
            Whether it has made them: all or none.
        """
        contents, timekeeper = self.world.contents, self.timekeeper
        step = timekeeper.step_nanoseconds
        last = timekeeper.nanoseconds + (count - 1) * step
        if last >= contents.plan.until or count > _MAX_STEPS_PER_CALL:
            return False
        messages = contents.plan.messages
        if messages is not None:
            if count > 1:
                return False
            messages.write(last)
        contents.physics.step_until_contact(timekeeper.step_size, count)
        timekeeper.nanoseconds = last + step
        return True

    def _step_until_contact(self, limit: int) -> int:
        """Makes steps in which no step hook is called; ends after one with a contact event."""
        contents, timekeeper = self.world.contents, self.timekeeper
        physics, plugins = contents.physics, contents.plugins
        counted = 0

        def count_steps() -> None:
            nonlocal counted
            timekeeper.step(physics.completed_steps - counted)
            counted = physics.completed_steps

        plugins.contacts.before_delivery = count_steps  # so that they get the time of their step
        try:
            with contents.deferred.lock:
                physics.step_until_contact(timekeeper.step_size, limit)
                count_steps()
        finally:
            plugins.contacts.before_delivery = None
        if contents.deferred.pending:
            contents.deferred.run_pending()
        self.transport.flush()
        return counted

    def _step_with_hooks(self) -> None:
        """Makes a step with all of its hooks."""
        contents, timekeeper = self.world.contents, self.timekeeper
        deferred, plugins = contents.deferred, contents.plugins
        if not deferred.defers_nothing:
            raise FlatlandError("a hook of a plugin cannot make a step")
        with deferred.lock:
            plugins.before_physics_step(timekeeper)
            contents.physics.step(timekeeper.step_size)
            timekeeper.step()
            plugins.after_physics_step(timekeeper)
        if deferred.pending:
            deferred.run_pending()
        self.transport.flush()

    # Other contents

    def reset(self: R, seed: Optional[int] = None, *, keep_time: bool = False) -> R:
        """Rebuilds the world as it was loaded, and returns this run.

        The run from then on equals, bit for bit, that of a newly loaded world. Models that were
        spawned are gone, and those that were deleted are back. Topics stay connected.

        Args:
            seed: of all random numbers from now on; None is the same as before.
            keep_time: whether simulated time goes on, instead of beginning at 0.

        Raises:
            UsageError: the seed is no whole number of 0 or more, or the simulation is closed.
            FlatlandError: a plugin does not start again, or a step is being made. The world is
                unchanged.
        """
        self.require_open()
        if seed is not None:
            seed = whole_number(seed, "a seed", 0)
        self.world.require_between_steps("reset")
        self.world.reset(seed)
        return self._jump_to(self.timekeeper.nanoseconds if keep_time else 0)

    def reload(self: R, config: WorldConfig, *, keep_time: bool = True) -> R:
        """Replaces the world's contents by those of other files, and returns this run.

        Args:
            config: contents of the new files; see `World.read_config`.
            keep_time: whether simulated time goes on, instead of beginning at 0.

        Raises:
            FlatlandError: a model or plugin does not start, or a step is being made. The world is
                unchanged.
        """
        self.require_open()
        self.world.require_between_steps("reload")
        self.world.rebuild(config, self.world.seed)
        return self._jump_to(self.timekeeper.nanoseconds if keep_time else 0)

    def save_state(self) -> bytes:
        """The state of the world and the time, for `load_state`: here, or in another process.

        This run and each one that loads the state are equal from then on, bit for bit.
        docs/plugins/programs_and_states.md tells what is saved of plugins.

        Raises:
            StateError: a plugin's state cannot be saved, or a model has no file that it could be
                read from again.
            UsageError: the simulation is closed.
            FlatlandError: a step is being made.
        """
        self.require_open()
        self.world.require_between_steps("save_state")
        return saved_states.save(self.world, self.timekeeper).dumps()

    def load_state(self: R, state: bytes) -> R:
        """Puts a world of equal files into a saved state, its time and seed included.

        Models and plugins are new objects, and the former ones are gone; topics stay connected.
        Files of models that were spawned are read again.

        Args:
            state: result of `save_state`.

        Returns:
            This run.

        Raises:
            FlatlandError: the state is damaged or does not fit, a file is missing, or a step is
                being made. The world is unchanged.
        """
        self.require_open()
        world = self.world
        world.require_between_steps("load_state")
        loaded = WorldState.loads(state)
        world.rebuild(world.config, loaded.seed, lambda: saved_states.restore(loaded, world))
        return self._jump_to(loaded.nanoseconds)

    def _jump_to(self: R, nanoseconds: int) -> R:
        """Sets the time after the world was rebuilt."""
        self.timekeeper.jump_to(nanoseconds)
        for callback in self.after_jump:
            callback()
        return self

    # Failures, and the end

    def _note_failure(self, failure: PluginFailure, error: BaseException) -> None:
        self._failures.append((failure, error))

    def _raise_failures(self) -> None:
        """Raises the first failure of a plugin that was noted since the last call."""
        if self._failures:
            failure, error = self._failures[0]
            self._failures.clear()
            raise PluginError(f'the plugin "{failure.label}" failed in {failure.reason}') from error

    def require_open(self) -> None:
        """Checks that the simulation is open.

        Raises:
            UsageError: it is closed.
        """
        if self._is_closed:
            raise UsageError("the simulation is closed")

    def close(self) -> None:
        """Stops all plugins. Later calls raise a UsageError; poses may still be read."""
        if not self._is_closed:
            self._is_closed = True
            self.world.close()

    def __enter__(self: R) -> R:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
