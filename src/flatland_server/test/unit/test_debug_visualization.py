"""When markers of models are made, sent and forgotten, with stand-ins for rospy's publishers."""

from dataclasses import replace

import pytest
import rospy
from visualization_msgs.msg import Marker, MarkerArray

from flatland_server import Circle, Pose
from flatland_server.messages.model_markers import ModelMarkers
from flatland_server.messages.wire_form import serialized
from flatland_server.ros.debug_visualization import DebugVisualization
from flatland_server.ros.rospy_patches import RospyCalls

DISC = "bodies: [{name: base, footprints: [{type: circle, radius: 0.1, density: 1}]}]"
TOPIC = "~debug/model/disc"


class Publisher:
    """A publisher that keeps the last message as a latched topic does."""

    def __init__(self, topic, message_type, subscriber_listener=None, *, queue_size, latch=False):
        self.topic, self.is_latched = topic, latch
        self.connections, self.kept, self.sent = 0, None, []

    def get_num_connections(self):
        return self.connections

    def publish(self, message):
        self.kept = message if self.is_latched else None
        if self.connections:
            self.sent.append(message)

    def unregister(self):
        self.kept = None


def markers(message):
    return MarkerArray().deserialize(serialized(message)).markers


def actions(message):
    return [marker.action for marker in markers(message)]


@pytest.fixture
def publishers(monkeypatch):
    """The publishers by topic."""
    made = {}

    def make(topic, *arguments, **options):
        made[topic] = Publisher(topic, *arguments, **options)
        return made[topic]

    monkeypatch.setattr(rospy, "Publisher", make)
    return made


@pytest.fixture
def visualization(files, publishers):
    """The visualization of a world with a disc, and the world."""
    files.write("disc.yaml", DISC)
    world = files.load("properties: {}\nlayers: []\nmodels: [{name: disc, model: disc.yaml}]")
    calls = replace(RospyCalls(), forget_latched=lambda publisher: setattr(publisher, "kept", None))
    yield DebugVisualization(world, 1e9, calls), world
    world.close()


def test_without_subscribers_markers_cost_nothing(visualization, publishers, monkeypatch):
    for work in ("place", "bytes"):
        monkeypatch.delattr(ModelMarkers, work)
    shown, world = visualization

    world.move_model("disc", Pose(1.0, 0.0, 0.0))
    shown.update()

    assert publishers[TOPIC].kept is None


def test_markers_are_latched_as_long_as_there_are_subscribers(visualization, publishers):
    shown, _ = visualization
    publisher = publishers[TOPIC]

    publisher.connections = 1
    shown.update()
    assert set(actions(publisher.kept)) == {Marker.ADD}

    publisher.connections = 0
    shown.update()
    assert publisher.kept is None


def test_a_new_model_of_a_name_does_not_begin_with_the_end_of_the_former(visualization, publishers):
    shown, world = visualization
    publisher = publishers[TOPIC]
    publisher.connections = 1
    shown.update()

    world.delete_model("disc")
    shown.update()

    assert actions(publisher.sent[-1]) == [Marker.DELETEALL]
    assert publisher.kept is None


def test_the_markers_show_a_changed_footprint_of_a_model_at_rest(visualization, publishers):
    shown, world = visualization
    publisher = publishers[TOPIC]
    publisher.connections = 1
    shown.update()
    shown.update()
    assert len(publisher.sent) == 1

    world.models["disc"].set_footprint("base", 0, Circle((0.0, 0.0), 0.7))
    shown.update()

    assert len(publisher.sent) == 2
    filled, *_ = markers(publisher.sent[-1])
    assert max(point.x for point in filled.points) == pytest.approx(0.7)
