"""What model plugins and world plugins have in common.

The life of a plugin: it is made; `on_initialize` reads its configuration and opens its topics;
then, at every step:

    prepare_step            the time is t
    before_physics_step     the time is t
        begin_contact       two fixtures start to touch        the time is still t
        pre_solve           before their contact is solved
        end_contact         they touch no longer
        post_solve          what the solver did to keep them apart
    after_physics_step      the time is t + dt

and at last `on_shutdown`, when its model is deleted, when it has failed, or when the world ends.
Its topics, subscriptions and transforms go away with its node. With an `update_timer`, the first
two and the last of a step's hooks come only when that is due; those of contacts come always, at the
contacts of the plugin's own model, or of the whole world. All of it happens on one thread. A hook
that a plugin does not override is never called and costs nothing; one that raises is its last.

In a hook, models are spawned, moved and deleted as ever, which then happens at the end of the step.
In the hooks of contacts, velocities can be set and forces applied, but no body be put elsewhere.
"""

from typing import Callable, Optional

import numpy as np

from flatland_server import _core
from flatland_server.config.yaml_reader import YamlReader
from flatland_server.timekeeper import Timekeeper
from flatland_server.transport.node import Node
from flatland_server.update_timer import UpdateTimer

CONTACT_HOOKS = {
    "begin_contact": _core.BEGIN_CONTACT,
    "pre_solve": _core.PRE_SOLVE,
    "end_contact": _core.END_CONTACT,
    "post_solve": _core.POST_SOLVE,
}
"""The hooks of contacts, and the moments of the core at which they are called."""

STEP_HOOKS = ("prepare_step", "before_physics_step", "after_physics_step")
"""The hooks around a step."""

HOOKS = (*STEP_HOOKS, *CONTACT_HOOKS)
"""All hooks of a step."""


class Plugin:
    """Base of `ModelPlugin` and `WorldPlugin`; plugins derive from one of these.

    Args:
        type: the type that its configuration gave.
        name: its name, unique in its model or world.
        node: its access to topics, transforms and parameters.
        rng: its source of chance. Equal seeds, models and plugin names give equal numbers.
    """

    def __init__(self, type: str, name: str, node: Node, rng: np.random.Generator) -> None:
        self.type = type
        self.name = name
        self.node = node
        self.rng = rng
        self._update_timer: Optional[UpdateTimer] = None
        self.on_new_timer: Optional[Callable[[], None]] = None
        """Called when the plugin gets another `update_timer`."""

    @property
    def update_timer(self) -> Optional[UpdateTimer]:
        """When the hooks before and after a step are called; None: at every step."""
        return self._update_timer

    @update_timer.setter
    def update_timer(self, timer: Optional[UpdateTimer]) -> None:
        self._update_timer = timer
        if self.on_new_timer is not None:
            self.on_new_timer()

    def on_initialize(self, config: YamlReader) -> None:
        """Reads the configuration and gets ready. Must be overridden.

        Raise any `FlatlandError` (`config.error(...)` makes one that names the line) to refuse; the
        model is then not spawned.
        """
        raise TypeError(f"{type(self).__name__} does not override on_initialize")

    def has_work(self) -> bool:
        """Whether there is something to do, once it is due; if not, it is not called.

        To be overridden by plugins that do nothing but publish, to ask whether anybody listens. It
        is asked again only when somebody begins or ends to listen to something.
        """
        return True

    def prepare_step(self, timekeeper: Timekeeper) -> None:
        """Called before the first `before_physics_step` of all plugins that are due.

        To ask early for what is done more quickly for many at a time; see `Lidar.expect_scan`.
        """

    def before_physics_step(self, timekeeper: Timekeeper) -> None:
        """Called before each step; the time is t."""

    def after_physics_step(self, timekeeper: Timekeeper) -> None:
        """Called after each step; the time is t + dt."""

    def begin_contact(self, contact: _core.Contact) -> None:
        """Called when two fixtures start to touch."""

    def end_contact(self, contact: _core.Contact) -> None:
        """Called when two fixtures touch no longer; also when one of them is deleted."""

    def pre_solve(self, contact: _core.Contact, old_manifold: _core.Manifold) -> None:
        """Called before a contact is solved, perhaps several times in a step; not with sensors.

        `contact.set_enabled(False)` lets the two pass through each other in this step.
        """

    def post_solve(self, contact: _core.Contact, impulse: _core.ContactImpulse) -> None:
        """Called after a contact is solved, perhaps several times in a step; not with sensors."""

    def on_shutdown(self) -> None:
        """Called once, before the plugin's topics go away."""
