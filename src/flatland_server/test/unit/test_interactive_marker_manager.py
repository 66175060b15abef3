"""When interactive markers are made again; the rest is in a rostest."""

from types import SimpleNamespace

import pytest
import rospy
from rospy import rostime
from visualization_msgs.msg import InteractiveMarkerFeedback

from flatland_server import Circle
from flatland_server.hub.client_edits import ClientEdits
from flatland_server.ros.interactive_marker_manager import InteractiveMarkerManager

DISC = "bodies: [{name: base, footprints: [{type: circle, radius: 0.5, density: 1}]}]"


class Server:
    """Keeps the markers that are inserted, without topics."""

    def __init__(self, topic):
        self.inserted, self.feedback = [], None
        self.update_pub = SimpleNamespace(get_num_connections=lambda: 0)

    def insert(self, marker, feedback):
        self.inserted.append(marker)
        self.feedback = feedback

    def applyChanges(self):
        pass

    def allow_drag(self, name):
        pass


def test_a_handle_follows_a_changed_footprint_but_not_while_it_is_dragged(files, monkeypatch):
    monkeypatch.setattr(rostime, "_rostime_initialized", True)
    monkeypatch.setattr(rostime, "_rostime_current", rospy.Time(1))
    files.write("disc.yaml", DISC)
    world = files.load("properties: {}\nlayers: []\nmodels: [{name: disc, model: disc.yaml}]")
    manager = SimpleNamespace(world=world, is_stepping=True, is_held=False)
    calls = SimpleNamespace(marker_server=Server)
    transport = SimpleNamespace(rospy_calls=calls, post=lambda action: action())
    hub = SimpleNamespace(manager=manager, world=world, edits=ClientEdits(world))
    markers = InteractiveMarkerManager(hub, transport, 1e9)
    server = markers._server

    def send(event):
        server.feedback(InteractiveMarkerFeedback(marker_name="disc", event_type=event))

    markers.update()
    markers.update()
    send(InteractiveMarkerFeedback.MOUSE_DOWN)
    world.models["disc"].set_footprint("base", 0, Circle((0.0, 0.0), 0.8))
    markers.update()
    assert [marker.scale / 2.5 for marker in server.inserted] == pytest.approx([0.5])
    send(InteractiveMarkerFeedback.MOUSE_UP)
    markers.update()
    markers.update()

    assert [marker.scale / 2.5 for marker in server.inserted] == pytest.approx([0.5, 0.8])
