"""Shared by the tests of objects that are kept after their end: plugins that keep contacts."""

from typing import Any, List

import numpy as np

from flatland_server.plugins.model_plugin import ModelPlugin
from flatland_server.simulation.world import World, WorldPlugin

ROBOT = """
bodies:
  - {name: base, footprints: [{type: circle, radius: 0.1, density: 1}]}
  - {name: wheel, footprints: [{type: circle, radius: 0.05, density: 1, layers: []}]}
joints:
  - type: revolute
    name: steering
    bodies: [{name: base, anchor: [0.1, 0]}, {name: wheel, anchor: [0, 0]}]
plugins: [{type: Keeper, name: keeper}, {type: Failing, name: failing}]
"""
WORLD = """
properties: {}
layers: [{name: walls}]
plugins: [{type: WorldKeeper, name: keeper}]
models: [{name: robot, model: robot.yaml}]
"""

kept: List[Any] = []
"""The contacts kept by plugins: (plugin, contact, further argument of the hook)."""


class Keeper(ModelPlugin):
    """Keeps all contacts and the other arguments of their hooks."""

    def on_initialize(self, config):
        pass

    def begin_contact(self, contact):
        kept.append((self, contact))

    def pre_solve(self, contact, old_manifold):
        kept.append((self, contact, old_manifold))

    def post_solve(self, contact, impulse):
        kept.append((self, contact, impulse))


class WorldKeeper(WorldPlugin):
    def on_initialize(self, config):
        self.node.subscribe("command", str, self._on_command)

    def begin_contact(self, contact):
        self.contact = contact

    def _on_command(self, _):
        pass


class Failing(ModelPlugin):
    def on_initialize(self, config):
        pass

    def begin_contact(self, contact):
        raise RuntimeError("no luck")


def lean_on_wall(files, robot: str) -> World:
    """A world in which a robot leans against a wall."""
    files.write("robot.yaml", robot)
    world = files.load(WORLD)
    world.add_walls("walls", np.array([[0.09, -5.0, 0.09, 5.0]]))
    return world
