"""Shared by the tests of the world: model files, plugins, and the state of a world."""

from typing import Any

from flatland_server.geometry import Pose, Transform
from flatland_server.plugins.model_plugin import ModelPlugin
from flatland_server.simulation.world import World, WorldPlugin
from flatland_server.transport.local_transport import LocalTransport

BODIES = """
bodies:
  - name: base
    footprints: [{type: circle, radius: 0.1, density: 1}]
  - name: head
    footprints: [{type: circle, radius: 0.1, density: 1}]
joints:
  - {type: weld, name: neck, bodies: [{name: base, anchor: [0, 0]}, {name: head, anchor: [0, 0]}]}
"""
EMPTY = "properties: {}\nlayers: []\n"


class Talker(ModelPlugin):
    """Publishes to "chatter", subscribes to "command" and publishes the frame "base"."""

    def on_initialize(self, config):
        self._publisher = self.node.advertise("chatter", str)
        self.node.subscribe("command", str, lambda _: None)
        self.node.claim_frame("odom", self.name_space_tf("base"))

    def after_physics_step(self, timekeeper):
        self._publisher.publish(f"{self.model.name} at {timekeeper.nanoseconds}")
        frame = self.name_space_tf("base")
        self.node.send_transform(
            Transform(timekeeper.nanoseconds, "odom", frame, self.model.base.pose)
        )


class Failing(ModelPlugin):
    """Opens topics and a frame, and then does not start."""

    def on_initialize(self, config):
        self.node.advertise("half_open", str)
        self.node.subscribe("half_subscribed", str, lambda _: None)
        self.node.claim_frame("odom", "half_placed")
        raise config.error("no luck")


class Herald(WorldPlugin):
    """Publishes the number of models."""

    def on_initialize(self, config):
        self._publisher = self.node.advertise("population", int)

    def after_physics_step(self, timekeeper):
        self._publisher.publish(len(self.world.models))


def spawn(files, world: World, model: str, name: str, **options: Any):
    """Spawns a model, by default without a namespace and at the origin."""
    namespace, pose = options.get("namespace", ""), options.get("pose", Pose())
    return world.spawn_model(files.folder / model, name, namespace, pose)


def state(world: World) -> tuple:
    """Everything that a failed spawn must leave unchanged."""
    assert isinstance(world.transport, LocalTransport)
    return (
        list(world.models),
        world.physics.body_count,
        world.physics.joint_count,
        world.transport.topics,
        world.transport.subscribed,
    )
