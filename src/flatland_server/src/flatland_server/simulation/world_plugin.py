"""The base class of plugins that belong to the world."""

from typing import TYPE_CHECKING

import numpy as np

from flatland_server.plugins.plugin import Plugin
from flatland_server.transport.node import Node

if TYPE_CHECKING:
    from flatland_server.simulation.world import World


class WorldPlugin(Plugin):
    """A plugin of the world.

    `flatland_server.plugins.plugin` describes the life of a plugin.

    Attributes:
        type: its type, as in its configuration.
        name: unique among the plugins of the world.
        node: its access to topics, transforms and parameters.
        rng: its random numbers, which depend only on the seed of the world and on its name.
        world: its world, with layers and models.
    """

    def __init__(
        self, type: str, name: str, node: Node, rng: np.random.Generator, world: "World"
    ) -> None:
        super().__init__(type, name, node, rng)
        self.world = world
