"""The services /undo and /redo: edits of all clients, one for each action."""

import math
from types import SimpleNamespace

import pytest
from edited_world import Server

from flatland_server.exceptions import FlatlandError
from flatland_server.geometry import Pose

WORLD = """\
properties: {}
layers: []
models:
- {name: a, model: box.yaml, pose: [2, 2.5, 0]}
- {name: b, model: box.yaml}
"""


@pytest.fixture
def server(files):
    return Server(files, WORLD)


def revert(server, service):
    return server.call(service)["message"]


def test_moves_spawns_and_deletions_are_undone_and_redone(server):
    poses = [server.poses()]
    for edit in (
        lambda: server.move("a", 0.0, 1.0, 0.5),
        lambda: server.spawn("c", 3.0, 3.0),
        lambda: server.delete("b"),
        lambda: server.delete("c"),
    ):
        edit()
        poses.append(server.poses())
    texts = ["Move a", "Spawn c", "Delete b", "Delete c"]

    for text, expected in zip(texts[::-1], poses[-2::-1]):
        assert server.edits.next_texts[0] == text
        assert revert(server, "undo") == f"Undone: {text}"
        assert server.poses() == expected
    with pytest.raises(FlatlandError, match="nothing to undo"):
        revert(server, "undo")
    assert server.edits.count == 0

    for text, expected in zip(texts, poses[1:]):
        assert server.edits.next_texts[1] == text
        assert revert(server, "redo") == f"Redone: {text}"
        assert server.poses() == expected
    with pytest.raises(FlatlandError, match="nothing to redo"):
        revert(server, "redo")


def test_several_models_are_one_edit_and_none_if_one_fails(server):
    def spawn(*names):
        pose = SimpleNamespace(x=1.0, y=1.0, theta=0.0)
        fields = {"yaml_path": "box.yaml", "ns": "", "pose": pose}
        models = [SimpleNamespace(name=name, **fields) for name in names]
        server.call("spawn_models", models=models)

    with pytest.raises(FlatlandError, match="already"):
        spawn("c", "c")
    assert server.edits.next_texts == ("", "")
    assert list(server.world.models) == ["a", "b"]

    spawn("c", "d")
    assert revert(server, "undo") == "Undone: Spawn 2 models"
    assert list(server.world.models) == ["a", "b"]

    server.call("delete_models", name=["a", "b"])
    revert(server, "undo")
    assert list(server.world.models) == ["a", "b"]


def test_a_model_comes_back_with_its_namespace_to_where_it_was(server):
    server.spawn("r", 1.0, 1.0, ns="~r1")
    server.world.models["r"].move(Pose(4.0, 4.0, 1.0))  # it has driven
    server.delete("r")
    revert(server, "undo")

    assert server.poses()["r"] == Pose(4.0, 4.0, 1.0)
    assert server.world.models["r"].namespace == "r1"
    assert [entry.pose for entry in server.edits.changes.added] == [Pose(1.0, 1.0, 0.0)]


def test_a_drag_is_one_edit_unless_it_ends_at_its_start(server):
    drag = None
    for x in (2.125, 2.25, 2.5):
        drag = server.edits.move("a", Pose(x, 2.5, 0.0), drag)
    another = server.edits.move("a", Pose(3.0, 2.5, 0.0))
    assert another is not drag
    revert(server, "undo")
    assert server.poses()["a"] == Pose(2.5, 2.5, 0.0)
    revert(server, "undo")
    assert server.poses()["a"] == Pose(2.0, 2.5, 0.0)
    assert server.edits.count == 0

    drag = server.edits.move("a", Pose(5.0, 5.0, 0.0))
    server.edits.move("a", Pose(2.0, 2.5, 1e-9), drag)
    assert server.edits.next_texts[0] == ""


def test_messages_for_one_model_in_a_row_are_one_edit(server):
    transport = server.manager.transport
    for name, x in (("a", 3.0), ("a", 4.0), ("b", 1.0), ("a", 5.0)):
        pose = SimpleNamespace(x=x, y=0.0, theta=0.0)
        transport.send("/move_model", SimpleNamespace(name=name, pose=pose))
        transport.process()

    texts = [revert(server, "undo") for _ in range(3)]
    assert texts == ["Undone: Move a", "Undone: Move b", "Undone: Move a"]
    assert server.poses()["a"] == Pose(2.0, 2.5, 0.0)
    assert server.edits.next_texts[0] == ""


def test_a_new_edit_leaves_nothing_to_redo_and_a_reset_nothing_to_undo(server):
    server.move("a", 0.0, 0.0)
    revert(server, "undo")
    server.move("b", 1.0, 0.0)
    assert server.edits.next_texts == ("Move b", "")

    server.reset()
    assert server.edits.next_texts == ("", "")
    with pytest.raises(FlatlandError, match="nothing to undo"):
        revert(server, "undo")


def test_an_edit_of_a_model_that_is_gone_is_dropped(server):
    server.move("b", 1.0, 0.0)
    server.move("a", 0.0, 0.0)
    server.world.delete_model("a")  # by a plugin
    with pytest.raises(FlatlandError, match='no model named "a"'):
        revert(server, "undo")
    assert server.edits.next_texts == ("Move b", "")


def test_all_models_of_an_edit_come_back_or_none(server, monkeypatch):
    server.call("delete_models", name=["a", "b"])
    server.world.spawn_model("box.yaml", "b", "", Pose())  # by a plugin
    with pytest.raises(FlatlandError, match='is a model named "b"'):
        revert(server, "undo")
    assert list(server.world.models) == ["b"]

    server.reset()
    server.call("delete_models", name=["a", "b"])
    add_model = server.world.add_model

    def fail(entry):
        if entry.name == "b":
            raise FlatlandError("a plugin does not start")
        return add_model(entry)

    monkeypatch.setattr(server.world, "add_model", fail)
    with pytest.raises(FlatlandError, match="does not start"):
        revert(server, "undo")
    assert list(server.world.models) == []


def test_models_that_delete_and_spawn_each_other_are_deleted_and_come_back(server, monkeypatch):
    add_model, delete_model = server.world.add_model, server.world.delete_model

    def add(entry):
        model = add_model(entry)
        if entry.name == "a":
            server.world.spawn_model("box.yaml", "b", "", Pose(1.0))
        return model

    def delete(name):
        delete_model(name)
        if name == "a":
            delete_model("b")

    monkeypatch.setattr(server.world, "add_model", add)
    monkeypatch.setattr(server.world, "delete_model", delete)
    before = server.poses()
    server.call("delete_models", name=["a", "b"])
    assert server.edits.changes.deleted == ["a", "b"]

    revert(server, "undo")
    assert server.poses() == before
    revert(server, "redo")
    assert server.poses() == {}


def test_the_state_names_the_next_edits(server):
    def state():
        for action in server.manager.on_tick:
            action()
        state = server.manager.transport.last("/flatland_server/state")
        return state.undo, state.redo, state.edits

    server.move("a", 0.0, 0.0, math.pi)
    assert state() == ("Move a", "", 1)
    revert(server, "undo")
    assert state() == ("", "Move a", 0)
