"""Interactive markers without a master; what rviz sees of them is in a rostest."""

import pytest
from edited_world import Server

from flatland_server import Circle
from flatland_server.hub.interactive_marker_manager import (
    Feedback,
    InteractiveMarkerManager,
    Update,
)
from flatland_server.real_time_timer import RealTimeTimer

WORLD = """\
properties: {}
layers: []
models: [{name: a, model: box.yaml}, {name: b, model: box.yaml, pose: [3, 0, 0]}]
"""
TOPIC = "/interactive_model_markers"


class Handles:
    """The markers of a world with two discs."""

    def __init__(self, files):
        self.server = Server(files, WORLD)
        self.transport = self.server.manager.transport
        self._manager = InteractiveMarkerManager(self.server.hub, 1e9)
        self.update()

    def update(self):
        self._manager.update()

    def send(self, event, x=0.0, name="a", client="rviz", control="drag"):
        feedback = Feedback(marker_name=name, event_type=event, client_id=client)
        feedback.control_name = control
        feedback.pose.position.x, feedback.pose.orientation.w = x, 1.0
        self.transport.send(f"{TOPIC}/feedback", feedback)
        self.transport.process()

    @property
    def all(self):
        """The markers of the latched message, by name."""
        return {
            each.name: each for each in self.transport.last_latched(f"{TOPIC}/update_full").markers
        }

    @property
    def x(self):
        return self.server.poses()["a"].x


@pytest.fixture
def handles(files, monkeypatch):
    monkeypatch.setattr(RealTimeTimer, "check_update", lambda timer: True)
    return Handles(files)


@pytest.fixture
def updates(handles):
    """The changes that are sent, without messages to keep alive."""
    updates = []
    handles.transport.subscribe(f"{TOPIC}/update", Update, updates.append)

    def take():
        handles.update()
        handles.transport.flush()
        taken = [each for each in updates if each.type == Update.UPDATE]
        updates.clear()
        return taken

    take()
    return take


def test_a_handle_follows_its_footprint_except_during_a_drag(handles):
    def radius():
        handles.update()
        return handles.all["a"].scale / 2.5

    assert radius() == pytest.approx(0.2)
    handles.send(Feedback.MOUSE_DOWN)
    handles.server.world.models["a"].set_footprint("base", 0, Circle((0.0, 0.0), 0.8))
    assert radius() == pytest.approx(0.2)
    handles.send(Feedback.MOUSE_UP)
    assert radius() == pytest.approx(0.8)


def test_a_dragged_model_belongs_to_its_client(handles, updates):
    handles.send(Feedback.MOUSE_DOWN, 0.0)
    handles.send(Feedback.POSE_UPDATE, 1.0)
    handles.send(Feedback.POSE_UPDATE, 7.0, client="other")
    handles.server.move("b", 4.0, 0.0)
    assert handles.x == 1.0
    assert [[each.name for each in update.poses] for update in updates()] == [["b"]]
    assert handles.server.manager.is_held

    handles.send(Feedback.MOUSE_UP, 1.5)
    assert not handles.server.manager.is_held
    [update] = updates()
    assert [(each.name, each.pose.position.x) for each in update.poses] == [("a", 1.5)]
    handles.send(Feedback.MOUSE_UP, 2.0, client="other")
    assert handles.x == 2.0


@pytest.mark.parametrize(("control", "x"), [("drag", 0.5), ("origin", 1.0)])
def test_a_drag_moves_the_centre_in_rviz_and_the_origin_in_the_window(handles, control, x):
    handles.server.world.models["a"].set_footprint("base", 0, Circle((0.5, 0.0), 0.2))
    handles.update()
    for event in (Feedback.MOUSE_DOWN, Feedback.POSE_UPDATE, Feedback.MOUSE_UP):
        handles.send(event, 1.0, control=control)
    assert handles.x == x


def test_a_drag_is_one_edit(handles):
    handles.send(Feedback.MOUSE_DOWN, 0.0)
    for x in (1.0, 2.0):
        handles.send(Feedback.POSE_UPDATE, x)
    handles.send(Feedback.MOUSE_UP, 2.5)

    handles.server.call("undo")

    assert handles.x == 0.0


def test_the_full_update_has_the_number_of_the_last_change(handles, updates):
    handles.server.move("a", 1.0, 0.0)
    handles.server.delete("b")
    [first] = updates()
    handles.server.spawn("b", 5.0, 0.0)
    handles.server.delete("a")
    handles.server.spawn("a", 6.0, 0.0)
    [second] = updates()

    assert ([each.name for each in first.poses], first.erases) == (["a"], ["b"])
    # The new one replaces the former one: a display would erase it after it has inserted it.
    assert ({each.name for each in second.markers}, second.erases) == ({"a", "b"}, [])
    assert second.seq_num == first.seq_num + 1
    full = handles.transport.last_latched(f"{TOPIC}/update_full")
    assert full.seq_num == second.seq_num
    xs = {name: each.pose.position.x for name, each in handles.all.items()}
    assert xs == {"a": 6.0, "b": 5.0}


def test_a_drag_out_of_the_world_leaves_the_model_and_warns_once(handles, caplog):
    handles.send(Feedback.MOUSE_DOWN)
    for _ in range(3):
        handles.send(Feedback.POSE_UPDATE, 1e9)
    assert handles.x == 0.0
    assert [record.message[:16] for record in caplog.records] == ['"a" is not moved']
