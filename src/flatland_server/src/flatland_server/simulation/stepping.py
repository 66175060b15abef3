"""Steps of a world: one with its hooks, or many at once where no hook is called."""

from flatland_server import _core
from flatland_server.exceptions import FlatlandError
from flatland_server.plugins.plugin_manager import PluginManager
from flatland_server.plugins.schedule import StepPlan
from flatland_server.simulation.deferred_actions import DeferredActions
from flatland_server.timekeeper import Timekeeper
from flatland_server.transport.transport import Transport

_MAX_STEPS_PER_CALL = 100
"""Python handles signals, such as Ctrl-C, between two calls of the core."""


class Stepping:
    """The part of a `World` that advances it.

    Attributes:
        plan: the time until which steps call no hooks, with the present plugins and subscribers.
    """

    plan: StepPlan
    transport: Transport
    physics: _core.World
    _plugins: PluginManager
    _deferred: DeferredActions

    def step(self, timekeeper: Timekeeper) -> None:
        """Advances the world and the timekeeper by one step.

        Runs no callbacks of subscriptions: `transport.process()` does, and `SimulationManager.step`
        does both.

        Args:
            timekeeper: advances with the world.

        Raises:
            FlatlandError: this is called by a hook of a plugin.
        """
        if not self._deferred.is_free:
            raise FlatlandError("a hook of a plugin cannot make a step")
        with self._deferred.lock:
            self._plugins.before_physics_step(timekeeper)
            self.physics.step(timekeeper.step_size)
            timekeeper.step()
            self._plugins.after_physics_step(timekeeper)
        if self._deferred.pending:
            self._deferred.run_pending()
        self.transport.flush()

    def step_up_to(self, timekeeper: Timekeeper, limit: int) -> int:
        """Makes as many steps as are possible in one call of the core, and at least one.

        The result, and what the hooks of plugins see, is that of so many calls of `step`. It ends
        before a step in which a plugin is due, after one in which a contact hook was called, and
        after one that is followed by callbacks, so that `transport.process()` may be called between
        any two steps that affect each other:

            while count > 0:
                world.transport.process()
                count -= world.step_up_to(timekeeper, count)

        Args:
            timekeeper: advances with the world.
            limit: of the number of steps, 1 or more.

        Returns:
            The number of steps made.

        Raises:
            FlatlandError: this is called by a hook of a plugin.
        """
        if self.transport.has_to_deliver:
            limit = 1
        is_current = self.plan.subscriber_revision == self.transport.subscriber_revision
        if is_current and not self._deferred.pending and self.step_as_planned(timekeeper, limit):
            self.transport.flush()
            return limit
        # A valid plan already tells whether a hook is to be called in the next step.
        steps = 0 if is_current and limit == 1 else self._steps_without_hooks(timekeeper, limit)
        if steps > 0:
            return self._step_until_contact(timekeeper, steps)
        self.step(timekeeper)
        return 1

    def step_as_planned(self, timekeeper: Timekeeper, count: int) -> bool:
        """Makes steps if that is one call of the core, without hooks: by the `plan`.

        For callers that have no messages to deliver, and know that subscribers are those of the
        plan; `step_up_to` finds out.

        Args:
            timekeeper: advances with the world.
            count: number of steps, 1 or more.

        Returns:
            Whether it has made them: all or none.
        """
        end = timekeeper.nanoseconds + count * timekeeper.step_nanoseconds
        if end - timekeeper.step_nanoseconds >= self.plan.until or count > _MAX_STEPS_PER_CALL:
            return False
        self.physics.step_until_contact(timekeeper.step_size, count)
        timekeeper.nanoseconds = end
        return True

    def _steps_without_hooks(self, timekeeper: Timekeeper, limit: int) -> int:
        """The number of steps from now on, up to a limit, that need no calls of step hooks."""
        if not self._deferred.is_free or self._deferred.pending:
            return 0
        return self._plugins.steps_without_hooks(timekeeper, min(limit, _MAX_STEPS_PER_CALL))

    def _step_until_contact(self, timekeeper: Timekeeper, limit: int) -> int:
        """Makes steps in which no step hook is called; ends after one with a contact event."""
        physics = self.physics
        counted = 0

        def count_steps() -> None:
            nonlocal counted
            timekeeper.step(physics.completed_steps - counted)
            counted = physics.completed_steps

        self._plugins.before_contact_hooks = count_steps  # so that they get the time of their step
        try:
            with self._deferred.lock:
                physics.step_until_contact(timekeeper.step_size, limit)
                count_steps()
        finally:
            self._plugins.before_contact_hooks = None
        if self._deferred.pending:
            self._deferred.run_pending()
        self.transport.flush()
        return counted
