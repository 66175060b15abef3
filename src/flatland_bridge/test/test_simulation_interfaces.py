"""The services of simulation_interfaces, by a client of rosbridge."""

import hashlib
import re
from pathlib import Path

import pytest

from flatland_bridge import simulation_interfaces, simulation_types
from flatland_server.messages.message_types import TYPES

BOX = "bodies: [{name: box, footprints: [{type: circle, radius: 0.1, density: 1}]}]"


@pytest.fixture
def call(client):
    """Calls a service of the standard; returns the response, or its result if that is not OK."""

    def call_it(name, /, **args):
        values = client.call(f"/{name}", **args)["values"]
        result = values.pop("result")
        return values if result["result"] == 1 else result

    return call_it


def spawn(call, name, x=0.0, y=0.0, w=1.0, **fields):
    pose = {"pose": {"position": {"x": x, "y": y}, "orientation": {"w": w}}}
    resource = {"resource_string": BOX}
    return call("spawn_entity", name=name, entity_resource=resource, initial_pose=pose, **fields)


def state(call):
    return call("get_simulation_state")["state"]["state"]


def test_the_types_are_those_of_the_standard():
    ros2 = pytest.importorskip("rosbags.typesys", reason="rosbags needs Python 3.10")
    assert ros2
    from flatland2d.ros2_messages import Ros2Messages

    names = [name for name in TYPES._added if name.startswith(f"{simulation_types.PACKAGE}/")]
    types = Ros2Messages()
    hashes = [f"{name.split('/')[1]} {types.type_of(TYPES.get(name)).type_hash}" for name in names]

    digest = hashlib.sha256("\n".join(sorted(hashes)).encode()).hexdigest()

    # of the RIHS01 hashes that rosbags computes from the files of simulation_interfaces 2.1.0
    assert digest == "026a040f029a193bdd4ab19543fb7ce84b411ef430b502ed379c0e38d2e16aa9"


def test_features_are_numbered(call, client):
    features = client.call("/get_simulator_features")["values"]["features"]

    assert len(features["features"]) == len(simulation_interfaces.FEATURES)
    assert {0, 1, 10, 11, 20, 26, 40, 50} <= set(features["features"])
    assert features["spawn_formats"] == ["yaml"]


def test_the_documentation_names_the_features():
    text = (Path(__file__).parents[3] / "docs/bridge.md").read_text()

    assert set(
        re.findall("`([A-Z_]{8,})`", text.partition("\n## simulation_interfaces")[2])
    ) == set(simulation_interfaces.FEATURES)


def test_a_spawned_entity_has_its_name_and_state(call):
    assert spawn(call, "box", 2.0, 1.0, entity_namespace="b") == {"entity_name": "box"}
    assert spawn(call, "box")["result"] == 101
    assert spawn(call, "box", allow_renaming=True) == {"entity_name": "box_2"}
    assert spawn(call, "")["result"] == 102
    assert spawn(call, "other", w=2.0)["result"] == 109
    assert spawn(call, "other", w=1e200)["result"] == 109
    assert call("spawn_entity", name="other")["result"] == 104
    assert call("get_entities", filters={"filter": "^b"})["entities"] == ["box", "box_2"]

    call("set_entity_state", entity="box", set_twist=True, state={"twist": {"linear": {"x": 1}}})
    call("step_simulation", steps=100)
    moved = call("get_entity_state", entity="box")["state"]
    assert moved["pose"]["position"]["x"] == pytest.approx(2.5, abs=1e-3)
    assert moved["twist"]["linear"]["x"] == pytest.approx(1.0, abs=1e-3)
    assert moved["header"] == {
        "seq": 0,
        "stamp": {"secs": 0, "nsecs": 500_000_000},
        "frame_id": "map",
    }

    call("delete_entity", entity="box")
    assert call("get_entity_state", entity="box")["result"] == 2
    assert call("get_entities_states")["entities"] == ["robot", "box_2"]


@pytest.mark.parametrize("twist", [{"linear": {"x": 1e300}}, {"angular": {"z": None}}])
def test_a_wrong_twist_moves_no_entity(call, twist):
    before = call("get_entity_state", entity="robot")["state"]["pose"]

    wrong = {"pose": {"position": {"x": 1.5}}, "twist": twist}
    result = call("set_entity_state", entity="robot", set_pose=True, set_twist=True, state=wrong)

    assert result == {"result": 4, "error_message": "expected a twist of up to 1e+09 m/s and rad/s"}
    assert call("get_entity_state", entity="robot")["state"]["pose"] == before


def test_moving_an_entity_is_an_edit_of_the_world(call, client):
    client.subscribed("/flatland_server/state")
    assert client.next_of("/flatland_server/state")["edits"] == 0

    state = {"pose": {"position": {"x": 1.5}}}
    call("set_entity_state", entity="robot", set_pose=True, state=state)

    assert any(client.next_of("/flatland_server/state")["edits"] == 1 for _ in range(10))


def test_a_group_is_spawned_as_far_as_possible(call, world):
    resource = {"uri": (world.parent / "robot.model.yaml").as_uri().replace("%20", " ")}
    entries = [{"name": name, "entity_resource": resource} for name in ("a", "robot", "b")]

    result = call("spawn_entities", spawn_requests=entries)

    assert result == {"result": 150, "error_message": "1 of 3 are not spawned"}
    assert call("get_entities")["entities"] == ["robot", "a", "b"]
    uris = [each["entity_resource"]["uri"] for each in call("get_spawnables")["spawnables"]]
    assert uris == [str(world.parent / "robot.model.yaml")]


def test_states_of_the_simulation(call):
    assert state(call) == 2
    assert call("set_simulation_state", state={"state": 1}) == {}
    assert call("set_simulation_state", state={"state": 1})["result"] == 101
    assert call("step_simulation", steps=1)["result"] == 4
    assert call("set_simulation_state", state={"state": 0}) == {}
    assert state(call) == 0
    assert call("set_simulation_state", state={"state": 3})["result"] == 0
    assert call("step_simulation") == {}
    assert state(call) == 2


@pytest.mark.parametrize(
    ("scope", "time", "names"),
    [(0, 0, ["robot"]), (6, 5_000_000, ["robot"]), (4, 5_000_000, []), (1, None, None)],
)
def test_scopes_of_a_reset(call, scope, time, names):
    spawn(call, "box", 2.0)
    call("delete_entity", entity="robot")
    call("step_simulation")

    result = call("reset_simulation", scope=scope)

    if time is None:
        assert result["result"] == 0
    else:
        assert call("get_entities")["entities"] == names
        spawn(call, "probe", 3.0)
        stamp = call("get_entity_state", entity="probe")["state"]["header"]["stamp"]
        assert stamp["nsecs"] == time


def test_worlds(call, world):
    assert call("get_current_world")["world"]["world_resource"]["uri"] == str(world)
    names = [each["name"] for each in call("get_available_worlds")["worlds"]]
    assert "office" in names
    assert call("load_world", world_resource={"uri": "crossing"})["world"]["name"] == "crossing"
    assert state(call) == 0
    assert call("load_world", world_resource={})["result"] == 102


@pytest.mark.parametrize("pattern", ["(a+)+$", "a*a*a*a*", "["])
def test_a_pattern_that_takes_long_is_refused(call, pattern):
    assert "error_message" in call("get_entities", filters={"filter": pattern})
