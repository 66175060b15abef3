"""When markers of models are made, sent and forgotten."""

import pytest
from direct_transport import DirectTransport
from visualization_msgs.msg import Marker, MarkerArray

from flatland_server import Circle, Pose
from flatland_server.hub.marker_publisher import MarkerPublisher
from flatland_server.messages.model_markers import ModelMarkers
from flatland_server.messages.wire_form import serialized

DISC = "bodies: [{name: base, footprints: [{type: circle, radius: 0.1, density: 1}]}]"
TOPIC = "/flatland_server/debug/model/disc"
ALL = "/flatland_server/debug/models"


class Transport(DirectTransport):
    """Keeps the messages of the model's topic."""

    def __init__(self):
        super().__init__(subscribed_topics=())
        self.sent = []

    def advertise(self, topic, *arguments, **options):
        publisher = super().advertise(topic, *arguments, **options)
        if topic == TOPIC:
            publish = publisher.publish
            publisher.publish = lambda message: self.sent.append(message) or publish(message)
        return publisher


def markers(message):
    return MarkerArray().deserialize(serialized(message)).markers


def actions(message):
    return [marker.action for marker in markers(message)]


def world_on(transport, files):
    """A world with a disc."""
    files.write("disc.yaml", DISC)
    text = "properties: {}\nlayers: []\nmodels: [{name: disc, model: disc.yaml}]"
    return files.load(text, transport=transport)


@pytest.fixture
def shown(files):
    """The markers of a world with a disc; the world; and the transport."""
    transport = Transport()
    world = world_on(transport, files)
    yield MarkerPublisher(world, transport, 1e9, for_rviz=True), world, transport
    world.close()


def test_without_subscribers_markers_cost_nothing(shown, monkeypatch):
    for work in ("place", "bytes"):
        monkeypatch.delattr(ModelMarkers, work)
    publisher, world, transport = shown

    world.move_model("disc", Pose(1.0, 0.0, 0.0))
    publisher.update()

    assert transport.last(TOPIC) is None


def test_markers_are_latched_as_long_as_there_are_subscribers(shown):
    publisher, _, transport = shown

    transport.set_subscribed_topics({TOPIC})
    publisher.update()
    assert set(actions(transport.last_latched(TOPIC))) == {Marker.ADD}

    transport.set_subscribed_topics(())
    publisher.update()
    assert transport.last(TOPIC) is None


def test_a_respawned_name_does_not_get_old_deletion_markers(shown):
    publisher, world, transport = shown
    transport.set_subscribed_topics({TOPIC})
    publisher.update()

    world.delete_model("disc")
    publisher.update()

    assert actions(transport.sent[-1]) == [Marker.DELETEALL]
    assert transport.last(TOPIC) is None


def test_the_markers_show_a_changed_footprint_of_a_model_at_rest(shown):
    publisher, world, transport = shown
    transport.set_subscribed_topics({TOPIC})
    publisher.update()
    publisher.update()
    assert len(transport.sent) == 1

    world.models["disc"].set_footprint("base", 0, Circle((0.0, 0.0), 0.7))
    publisher.update()

    assert len(transport.sent) == 2
    filled, *_ = markers(transport.sent[-1])
    assert max(point.x for point in filled.points) == pytest.approx(0.7)


def test_viewers_other_than_rviz_get_one_topic_with_all_models(files):
    transport = DirectTransport()
    world = world_on(transport, files)
    publisher = MarkerPublisher(world, transport, 1e9, for_rviz=False)

    publisher.update()
    assert set(actions(transport.last(ALL))) == {Marker.ADD}
    world.delete_model("disc")
    publisher.update()

    assert actions(transport.last(ALL)) == [Marker.DELETEALL]
    names = {topic.rpartition("/")[2] for topic in transport.topics}
    assert names == {"layers", "models", "walls"}
    world.close()
