"""Parameters that clients read and set, without ROS."""

import json

import pytest
from bridge_clients import Client, running

from flatland_bridge.parameters import MOST_BYTES

MODEL = """
bodies:
  - name: base
    footprints:
      - type: circle
        radius: $eval param("/robot/radius", 0.3)
        density: 1
"""


def asked(client, service, **arguments):
    """The answer of a service of rosapi."""
    response = client.call(f"/rosapi/{service}", **arguments)
    assert response["result"], response["values"]
    return response["values"]


def value_of(client, name, default=""):
    return json.loads(asked(client, "get_param", name=name, default=default)["value"])


def check_parameters(client, node):
    """Sets, reads, searches and deletes parameters, with the same results at each door.

    Args:
        client: of rosbridge.
        node: the name of the node with the namespace that is searched.
    """

    def put(name, value):
        assert asked(client, "set_param", name=name, value=json.dumps(value)) == {}

    put("/robot/speed", 1.5)
    put("robot/name", "ä b")
    put("/robot/arm", {"joints": [1, {"x": True}], "a key": ""})
    arm = {"joints": [1, {"x": True}], "a key": ""}
    assert value_of(client, "/robot") == {"speed": 1.5, "name": "ä b", "arm": arm}
    assert value_of(client, "/robot/arm/joints") == [1, {"x": True}]
    names = asked(client, "get_param_names")["names"]
    assert {"/robot/speed", "/robot/name", "/robot/arm/joints"} <= set(names)
    assert "/robot" not in names
    for name, exists in (("/robot", True), ("/robot/speed", True), ("/robot/speed/x", False)):
        assert asked(client, "has_param", name=name) == {"exists": exists}
    assert [value_of(client, "/nope", default) for default in ("", "[1]", "text")] == [
        *(None, [1], "text")
    ]

    put(f"{node}/gain", 2)
    for name, found in (
        ("gain", f"{node}/gain"),
        ("robot", "/robot"),
        ("robot/nope", "/robot/nope"),  # the first part decides
        ("nope", ""),
        ("/robot/speed", "/robot/speed"),
        ("/gain", ""),
    ):
        assert asked(client, "search_param", name=name) == {"global_name": found}

    put("/robot/speed", {"max": 2.0})
    assert value_of(client, "/robot/speed/max") == 2.0
    assert asked(client, "delete_param", name="/robot/speed/max") == {}
    assert asked(client, "delete_param", name="/robot/speed/max") == {}  # as rosapi's
    assert value_of(client, "/robot/speed") == {}
    asked(client, "delete_param", name="/robot")
    assert value_of(client, "/robot") is None


def test_clients_set_search_and_delete_parameters(client):
    check_parameters(client, "/flatland_server")


def test_models_use_parameters_of_clients_and_command_line(world):
    (world.parent / "sized.model.yaml").write_text(MODEL)
    with running(world, is_paused=True, params={"robot": {"radius": -1.0}, "odd": {1: None}}) as it:
        client = Client(it)

        def spawn():
            return client.call("/spawn_model", yaml_path="sized.model.yaml", name="x")["values"]

        assert value_of(client, "/robot/radius") == -1.0
        assert value_of(client, "/odd") == {"1": None}
        assert "radius" in spawn()["message"]
        asked(client, "set_param", name="/robot/radius", value="0.5")
        assert spawn()["success"]


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("a b", "1", "expected a name as name, found 'a b'"),
        ("", "1", "expected a name as name"),
        ("/" + 300 * "x", "1", "expected a name as name"),
        ("/x", 1, "value: expected text, found 1"),
        ("/x", "{", "expected JSON"),
        ("/x", "[" * 200 + "]" * 200, "expected 100 levels"),
        ("/x", "null", "expected a value that a parameter of ROS can have: cannot marshal None"),
        ("/x", "[1, {\"a\": 2147483648}]", "a parameter of ROS can have: int exceeds"),
        ("/x", '"\\u0001"', "a parameter of ROS can have: not well-formed"),
    ],
)  # fmt: skip
def test_a_wrong_parameter_is_refused_and_changes_nothing(client, name, value, expected):
    asked(client, "set_param", name="/x", value="7")

    response = client.call("/rosapi/set_param", name=name, value=value)

    assert not response["result"]
    assert expected in response["values"]
    assert asked(client, "get_param_names")["names"] == ["/x"]
    assert value_of(client, "/x") == 7


def test_parameters_of_all_clients_are_limited(client):
    check_limit(client)


def check_limit(client):
    """Parameters that clients set take limited memory, which deleting frees."""
    text = json.dumps("x" * (MOST_BYTES // 5))
    names = [f"/many/p{number}" for number in range(5)]
    for name in names[:4]:
        asked(client, "set_param", name=name, value=text)
    refused = client.call("/rosapi/set_param", name=names[4], value=text)
    assert refused["values"].endswith("found more; delete_param makes room")
    assert value_of(client, names[4]) is None
    asked(client, "set_param", name=names[3], value=text)  # in its own place

    asked(client, "set_param", name="/many", value="{}")  # in place of them all
    for name in names[:4]:
        asked(client, "set_param", name=name, value=text)
    asked(client, "delete_param", name="/many")
    asked(client, "set_param", name=names[4], value=text)
    asked(client, "delete_param", name="/many")
