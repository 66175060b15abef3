"""The base class of plugins, and their life.

A plugin is a class with hooks: methods that the simulation calls, each at its point in the life of
the plugin. The hooks of the base class are empty; a plugin overrides those that it needs, and the
others are never called.

1. `__init__` sets `self.model` or `self.world`, `self.node` and `self.rng`. It need not be
   overridden.

2. `on_initialize`: the plugin reads its configuration and opens its topics. If this fails, the
   model is not spawned.

3. In every step, from simulated time t to t + dt:

    hook                  called                                                 time
    prepare_step          on all plugins, before the first before_physics_step   t
    before_physics_step   before the physics                                     t
    begin_contact         when two fixtures have started to touch                t
    end_contact           when two fixtures have ceased to touch                 t
    pre_solve             before the forces of a contact are solved              t
    post_solve            after the forces of a contact were solved              t
    after_physics_step    after the physics                                      t + dt

4. `on_shutdown`: the model is deleted, the plugin has failed, or the world is closed or rebuilt.
   After it, the topics, subscriptions and frames of the plugin are closed.

`get_state` is called between two steps, when the state of the world is saved. When the world is
reset, or a state is loaded, plugins are new objects; a loaded state is passed to `set_state`.

In each hook, plugins are called in the order in which they were started. All hooks and the
callbacks of subscriptions are called on the same thread; callbacks are called between steps.

Step hooks, which are `prepare_step`, `before_physics_step` and `after_physics_step`, are called in
every step, or, if the plugin has an `update_timer`, in those in which it is due. They are not
called while `has_work` returns False. Contact hooks are the other four. They are always called: for
a `ModelPlugin` at contacts of its model, for a `WorldPlugin` at all contacts.

A plugin fails if one of its hooks or callbacks raises an exception. This is logged, and the plugin
is shut down and not called again; all others go on.

Any hook may spawn, move and delete models; within a step, this takes effect at its end. Contact
hooks may set velocities and apply forces and impulses, but not place, add or remove bodies.
"""

from typing import Any, Callable, Optional, Sequence

import numpy as np

from flatland_server import _core
from flatland_server._core import StepMessage
from flatland_server.canvas import Canvas
from flatland_server.config.yaml_reader import REQUIRED, YamlReader
from flatland_server.models.model import Model
from flatland_server.plugins.batch_role import BatchRole
from flatland_server.timekeeper import Timekeeper
from flatland_server.transport.node import Node
from flatland_server.update_timer import UpdateTimer

CONTACT_HOOKS = {
    "begin_contact": _core.BEGIN_CONTACT,
    "pre_solve": _core.PRE_SOLVE,
    "end_contact": _core.END_CONTACT,
    "post_solve": _core.POST_SOLVE,
}
"""The hooks for contacts, each with the event of the core at which it is called."""

STEP_HOOKS = ("prepare_step", "before_physics_step", "after_physics_step")
"""The hooks before and after the physics of a step, in the order of their calls."""

HOOKS = (*STEP_HOOKS, *CONTACT_HOOKS)
"""All hooks that are called in a step."""


def plugin_label(owner: str, name: str) -> str:
    """`model/plugin`, or only the name for a plugin of the world."""
    return f"{owner}/{name}" if owner else name


class Plugin:
    """The base class of `ModelPlugin` and `WorldPlugin`; plugins derive from one of these.

    Attributes:
        type: its type, as in its configuration.
        name: unique among the plugins of its model, or of the world.
        node: its access to topics, transforms and parameters.
        rng: its random numbers, which depend only on the seed of the world and on the names of the
            model and the plugin.
    """

    accept_other_keys = False
    """True if keys that it does not read are accepted, instead of refused as misspelt."""

    def __init_subclass__(cls, **arguments: Any) -> None:
        """Drops what a class that overrides a hook inherits beside it."""
        super().__init_subclass__(**arguments)
        for name in ("batch_role", "step_messages"):
            if name not in vars(cls) and not any(
                getattr(cls, name) is getattr(base, name)
                and all(getattr(cls, hook) is getattr(base, hook) for hook in HOOKS)
                for base in cls.__bases__
                if issubclass(base, Plugin)
            ):
                setattr(cls, name, getattr(Plugin, name))

    def __init__(self, type: str, name: str, node: Node, rng: np.random.Generator) -> None:
        self.type = type
        self.name = name
        self.node = node
        self.rng = rng
        self._update_timer: Optional[UpdateTimer] = None
        self.timer_observer: Optional[Callable[[], None]] = None
        """Called when the plugin gets another `update_timer`; for the schedule."""

    @property
    def update_timer(self) -> Optional[UpdateTimer]:
        """The timer of the step hooks; None: they are called in every step. Any hook may set it."""
        return self._update_timer

    @update_timer.setter
    def update_timer(self, timer: Optional[UpdateTimer]) -> None:
        self._update_timer = timer
        if self.timer_observer is not None:
            self.timer_observer()

    def on_initialize(self, config: YamlReader) -> None:
        """Reads the configuration and opens topics. Must be overridden.

        Args:
            config: the plugin's entry in its file. Keys that are not read here are reported as
                unknown.

        Raises:
            FlatlandError: the plugin cannot start, and so the model is not spawned. Best raised by
                `config.error(...)`, which adds the file and the line.
        """
        raise TypeError(f"{type(self).__name__} does not override on_initialize")

    @property
    def batch_role(self) -> Optional[BatchRole]:
        """The plugin's part in a `SimulationBatch`; None: batches refuse it.

        To be overridden by a property, or by an attribute of the class, such as `BatchRole()` for a
        plugin that only observes. A derived class that overrides a hook has to do so again.
        """
        return None

    @property
    def people(self) -> Sequence[Model]:
        """The models that the plugin moves as people: sweeps measure distances from them.

        Some of them may be away, see `Model.is_away`.
        """
        return ()

    @property
    def groups(self) -> Sequence[Sequence[Model]]:
        """Its people that belong together, group by group."""
        return ()

    def get_frame_id(self, config: YamlReader, key: str, default: Any = REQUIRED) -> str:
        """The frame named by a key of the configuration, such as `odom_frame_id`.

        For frames outside of the model, which are used as they are written, unless they begin with
        "~": `~odom` is `<namespace>_odom`, or `odom` without a namespace, so that several models
        can be spawned from one file. A leading "/" is stripped, because tf2 does not look up frames
        that begin with it. Frames of the model itself are named by `name_space_tf`.

        Args:
            config: the plugin's configuration.
            key: the key of the frame.
            default: the frame if the key is missing; without it, the key is required.
        """
        frame_id = config.get_frame(key, default)
        if not frame_id.startswith("~"):
            return frame_id.lstrip("/")
        bare = frame_id[1:].lstrip("/")
        if not bare:
            config.problem(f'expected a frame, such as "~odom", found "{frame_id}"', key)
        return self.node.name_frame(bare)

    def has_work(self) -> bool:
        """True if the step hooks need to be called now.

        To be overridden by plugins that only publish, which have no work while their topics have no
        subscribers. Called again only after a topic has got or lost a subscriber, plugins were
        started or stopped, or one has set its `update_timer`: the answer may depend on nothing
        else.
        """
        return True

    def step_messages(self) -> Sequence[Optional[StepMessage]]:
        """The messages that the core writes at each step, in place of the plugin's step hooks.

        For plugins without an `update_timer` that only publish poses and velocities, before the
        physics. Called after `has_work`. Without a message, or with a None among them, the hooks
        are called. A derived class that overrides a hook has to override this again.
        """
        return ()

    def prepare_step(self, timekeeper: Timekeeper) -> None:
        """Called on all plugins that are due, before `before_physics_step` of the first of them.

        For work that is faster if it is done for several plugins together: here each of them can
        request it; see `Lidar.expect_scan`.

        Args:
            timekeeper: the simulated time, t.
        """

    def before_physics_step(self, timekeeper: Timekeeper) -> None:
        """Called before the physics.

        Args:
            timekeeper: the simulated time, t.
        """

    def after_physics_step(self, timekeeper: Timekeeper) -> None:
        """Called after the physics.

        Args:
            timekeeper: the simulated time, t + dt.
        """

    def begin_contact(self, contact: _core.Contact) -> None:
        """Called when two fixtures have started to touch.

        Args:
            contact: the contact of these fixtures.
        """

    def end_contact(self, contact: _core.Contact) -> None:
        """Called when two fixtures have ceased to touch, or one that touches is deleted.

        Args:
            contact: the contact of these fixtures.
        """

    def pre_solve(self, contact: _core.Contact, old_manifold: _core.Manifold) -> None:
        """Called before a contact is solved, possibly several times in a step; not for sensors.

        Args:
            contact: `contact.set_enabled(False)` lets the two fixtures pass through each other in
                this step.
            old_manifold: the points of the contact in the last step.
        """

    def post_solve(self, contact: _core.Contact, impulse: _core.ContactImpulse) -> None:
        """Called after a contact was solved, possibly several times in a step; not for sensors.

        Args:
            contact: with the points where the two fixtures touch.
            impulse: applied at each of these points to keep the fixtures apart [N s].
        """

    def draw(self, canvas: Canvas, timekeeper: Timekeeper) -> None:
        """Draws the plugin's part of a picture of the world, such as a lidar's returns.

        Called between steps, when a picture with sensors is asked for. It must not change anything:
        a run is the same with pictures and without.

        Args:
            canvas: picture to draw on.
            timekeeper: the simulated time.
        """

    def publish_now(self, timekeeper: Timekeeper) -> None:
        """Publishes a new measurement on those of its topics that have subscribers.

        To be overridden by sensors. Called between steps, when one of its topics is read for the
        first time (`Simulation.last`). It changes nothing that the plugin publishes later.

        Args:
            timekeeper: the simulated time.
        """

    def on_shutdown(self) -> None:
        """Called once, at the end of the plugin; its topics are still open."""

    def get_state(self) -> Any:
        """The attributes that the plugin keeps from step to step; see `set_state`.

        To be overridden by plugins with attributes that change after `on_initialize`. The framework
        itself keeps `rng`, `update_timer`, and what the core moves: bodies, drives, tweens, drifts
        and crowds. A plugin that has nothing else overrides it to return None: those that do
        not override it are named when a state is saved.

        Returns:
            Plain data: None, numbers, strings, bytes, numpy arrays of numbers, and lists and dicts
            of these. Tuples come back as lists. A contact is described by its fixtures; see
            `Entities.describe` (`self.model.entities`, `self.world.entities`).
        """
        return None

    def set_state(self, state: Any) -> None:
        """Restores a state: of this plugin, or of the same plugin in another process.

        Called between steps on a plugin that has just been initialized, when all models and bodies
        are there, in their places. What it publishes afterwards must be the same as without saving
        and restoring.

        Args:
            state: as `get_state` has returned it.
        """
