"""The server's messages about its models."""

import math
from types import SimpleNamespace

import pytest

from flatland_server import Circle, Pose
from flatland_server.hub.model_publisher import ModelPublisher
from flatland_server.transport.local_transport import Tap

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


LIST, STATES = "/flatland_server/models", "/flatland_server/model_states"


class Published(Tap):
    """The messages of topics; has subscribed to some of them."""

    def __init__(self):
        self.sent = {LIST: [], STATES: []}
        self.subscribed = set()

    def wants(self, topic):
        return topic in self.subscribed

    def receive(self, topic, message, is_latched):
        self.sent[topic].append(message)

    def receive_transform(self, transform):
        pass


@pytest.fixture
def published(files):
    """The published messages, the simulation, and the publisher of its models."""
    files.write("cart.yaml", CART)
    world, clock = files.load(WORLD), SimpleNamespace(nanoseconds=0)
    simulation = SimpleNamespace(world=world, transport=world.transport, timekeeper=clock)
    tap = Published()
    tap.subscribed.add(LIST)
    simulation.transport.set_subscribed_topics(())
    simulation.transport.open_tap(tap)
    yield tap, simulation, ModelPublisher(simulation, 1e9)
    simulation.world.close()


def test_a_model_is_described(published, files):
    [listed] = published[0].sent[LIST]
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
    assert len(publishers.sent[LIST]) == 1

    simulation.world.models["cart"].set_footprint("base", 0, Circle((1.0, 0.0), 2.0))
    publisher.update()
    assert publishers.sent[LIST][1].models[0].bodies[0].max_x == 3.0
    simulation.world.delete_model("cart")
    publisher.update()
    assert publishers.sent[LIST][2].models == []


def test_model_states_contain_only_models_that_moved(published):
    publishers, simulation, publisher = published
    states = publishers.sent[STATES]
    publisher.update()
    assert states == []  # no subscriber
    publishers.subscribed.add(STATES)
    simulation.transport.set_subscribed_topics(())  # which counts as a change
    publisher.update()
    [cart] = states[0].models
    assert (cart.pose.x, cart.pose.y, cart.pose.theta) == (1.0, 2.0, 0.0)
    assert [(body.x, body.y) for body in cart.bodies[:2]] == [(1.0, 2.0), (3.0, 2.0)]

    publisher.update()
    assert len(states) == 1  # nothing has moved, and no time has passed
    simulation.timekeeper.nanoseconds = 5_000_000
    publisher.update()
    assert states[1].models == []
    assert states[1].stamp.to_sec() == 0.005

    simulation.world.move_model("cart", Pose(0.0, 0.0, math.pi / 2))
    publisher.update()
    [cart] = states[2].models
    assert [cart.bodies[1].x, cart.bodies[1].y] == pytest.approx([0.0, 2.0], abs=1e-6)
    assert cart.bodies[0].theta == pytest.approx(math.pi / 2)
