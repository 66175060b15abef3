"""The server's messages about its models, with stand-ins for rospy's publishers."""

import math

import pytest
import rospy

from flatland_server import Circle, Pose
from flatland_server.ros.model_publisher import ModelPublisher

CART = """
bodies:
  - name: base
    footprints: [{type: circle, radius: 0.5, center: [1, 0], density: 1}]
  - name: arm
    pose: [2, 0, 0]
    footprints: [{type: polygon, points: [[0, 0], [1, 0], [1, 0.2]], density: 1}]
  - {name: ghost, footprints: []}
plugins:
  - {type: DiffDrive, name: drive, body: base}
"""
WORLD = """
properties: {}
layers: []
models: [{name: cart, namespace: /a/, model: cart.yaml, pose: [1, 2, 0]}]
"""


class Publisher:
    def __init__(self, topic, message_type, *, queue_size, latch=False):
        self.make, self.connections, self.sent = message_type, 0, []

    def get_num_connections(self):
        return self.connections

    def publish(self, *values):
        self.sent.append(self.make(*values))


@pytest.fixture
def published(files, monkeypatch):
    """The publishers by topic, the simulation, and the publisher of its models."""
    made = {}

    def make(topic, *arguments, **options):
        made[topic] = Publisher(topic, *arguments, **options)
        return made[topic]

    monkeypatch.setattr(rospy, "Publisher", make)
    files.write("cart.yaml", CART)
    simulation = WorldSimulation(files, WORLD)
    yield made, simulation, ModelPublisher(simulation, 1e9)
    simulation.world.close()


class WorldSimulation:
    """The part of a simulation manager that the publisher uses."""

    def __init__(self, files, world):
        self.world = files.load(world)
        self.timekeeper = self
        self.nanoseconds = 0


def test_a_model_is_described(published, files):
    [listed] = published[0]["~models"].sent
    [cart] = listed.models

    assert (cart.name, cart.ns) == ("cart", "a")
    assert cart.yaml_path == str((files.folder / "cart.yaml").resolve())
    base, arm, ghost = cart.bodies
    assert (base.name, base.frame_id) == ("base", "a_base")
    assert (base.min_x, base.min_y, base.max_x, base.max_y) == (0.5, -0.5, 1.5, 0.5)
    assert (arm.min_x, arm.min_y, arm.max_x, arm.max_y) == pytest.approx((0, 0, 1, 0.2))
    assert ghost.min_x == ghost.max_x == 0.0
    [drive] = cart.plugins
    assert (drive.name, drive.type, drive.has_failed) == ("drive", "DiffDrive", False)
    topics = {(topic.name, topic.type, topic.is_published) for topic in drive.topics}
    assert ("/a/cmd_vel", "geometry_msgs/Twist", False) in topics
    assert ("/a/odometry/filtered", "nav_msgs/Odometry", True) in topics


def test_the_list_is_published_when_models_come_change_and_go(published):
    publishers, simulation, publisher = published
    publisher.update()
    assert len(publishers["~models"].sent) == 1

    simulation.world.models["cart"].set_footprint("base", 0, Circle((1.0, 0.0), 2.0))
    publisher.update()
    assert publishers["~models"].sent[1].models[0].bodies[0].max_x == 3.0
    simulation.world.delete_model("cart")
    publisher.update()
    assert publishers["~models"].sent[2].models == []


def test_states_have_what_has_moved(published):
    publishers, simulation, publisher = published
    states = publishers["~model_states"]
    publisher.update()
    assert states.sent == []  # no subscriber
    states.connections = 1
    publisher.update()
    [cart] = states.sent[0].models
    assert (cart.pose.x, cart.pose.y, cart.pose.theta) == (1.0, 2.0, 0.0)
    assert [(body.x, body.y) for body in cart.bodies[:2]] == [(1.0, 2.0), (3.0, 2.0)]

    publisher.update()
    assert len(states.sent) == 1  # nothing has moved, and no time has passed
    simulation.nanoseconds = 5_000_000
    publisher.update()
    assert states.sent[1].models == []
    assert states.sent[1].stamp.to_sec() == 0.005

    simulation.world.move_model("cart", Pose(0.0, 0.0, math.pi / 2))
    publisher.update()
    [cart] = states.sent[2].models
    assert [cart.bodies[1].x, cart.bodies[1].y] == pytest.approx([0.0, 2.0], abs=1e-6)
    assert cart.bodies[0].theta == pytest.approx(math.pi / 2)
