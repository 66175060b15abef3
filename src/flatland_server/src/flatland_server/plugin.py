"""What model plugins and world plugins have in common.

The life of a plugin: it is made; `on_initialize` reads its configuration and opens its topics;
then, at every step, `before_physics_step` at time t and `after_physics_step` at time t + dt, or,
with an `update_timer`, only when that is due; at last `on_shutdown`, when its model is deleted or
the world ends. Its topics, subscriptions and transforms go away with its node. All of it happens on
one thread, between steps; a hook that a plugin does not override is never called and costs nothing.
"""

from typing import Optional

import numpy as np

from flatland_server.node import Node
from flatland_server.timekeeper import Timekeeper
from flatland_server.update_timer import UpdateTimer
from flatland_server.yaml_reader import YamlReader

HOOKS = ("before_physics_step", "after_physics_step")


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
        self.update_timer: Optional[UpdateTimer] = None

    def on_initialize(self, config: YamlReader) -> None:
        """Reads the configuration and gets ready. Must be overridden.

        Raise any `FlatlandError` (`config.error(...)` makes one that names the line) to refuse; the
        model is then not spawned.
        """
        raise TypeError(f"{type(self).__name__} does not override on_initialize")

    def before_physics_step(self, timekeeper: Timekeeper) -> None:
        """Called before each step; the time is t."""

    def after_physics_step(self, timekeeper: Timekeeper) -> None:
        """Called after each step; the time is t + dt."""

    def on_shutdown(self) -> None:
        """Called once, before the plugin's topics go away."""
