"""Message types that a user adds, by `messages.add` or in a package's folder msg."""

import genpy
import pytest

from flatland_server import MessageError, messages
from flatland_server.messages import times
from flatland_server.messages.message_types import MessageTypes
from flatland_server.messages.wire_form import serialized

DEFINITION = """
# A robot's load.
float32 EMPTY = 0.5      # kg
string UNIT = "kg" # all of it
bool HEAVY=True
Header header
float32[2] limits  # kg
Part[] parts
geometry_msgs/Point[] at
time since
"""


def test_an_added_type_equals_the_one_generated_by_ros():
    from genpy.dynamic import generate_dynamic

    types = MessageTypes(use_ros=False)
    types.add("my_plugins/Part", "string name\nuint8[] code")
    load = types.add("my_plugins/Load", DEFINITION)

    ros = generate_dynamic("my_plugins/Load", load._full_text)["my_plugins/Load"]
    assert types.get("my_plugins/Load") is load
    assert (load._md5sum, load._slot_types) == (ros._md5sum, ros._slot_types)
    assert (load.EMPTY, load.UNIT, load.HEAVY) == (ros.EMPTY, ros.UNIT, ros.HEAVY)
    part = types.get("my_plugins/Part")("wheel", b"\1\2")
    message = load(limits=[1.0, 2.0], parts=[part], since=times.Time(3, 4))
    assert serialized(ros().deserialize(serialized(message))) == serialized(message)


def test_rospy_can_publish_an_added_type():
    cls = messages.add("my_plugins/Mass", "std_msgs/Header header\nfloat64 mass")
    message = cls(mass=3.0)

    assert issubclass(cls, genpy.Message)
    assert isinstance(message.header, messages.get("std_msgs/Header"))
    genpy.message.check_type("header", "std_msgs/Header", message.header)
    assert cls().deserialize(serialized(message)) == message
    assert str(message).endswith("mass: 3.0")  # as ROS's


@pytest.mark.parametrize(
    ("name", "definition", "message"),
    [
        (
            "my_plugins/A",
            "float64 x\nflaot64 y",
            'my_plugins/A:2: expected a type, found "flaot64"',
        ),
        ("my_plugins/A", "float64", "my_plugins/A:1: expected a type and a name"),
        ("my_plugins/A", "float64 x\n\nint8 x", 'A:3: expected each name once, found "x"'),
        ("my_plugins/A", "int8 X=y", "my_plugins/A:1: expected the value of a int8 constant"),
        ("my_plugins/A", "A[] a", "my_plugins/A contains itself"),
        ("my_plugins/A", "geometry_msgs/Pont a", '(did you mean "geometry_msgs/Point"?)'),
        ("my_plugins/A", "int8 from", 'that is no keyword of Python, found "from"'),
        ("my_plugins/A", 7, "my_plugins/A: expected a definition, found 7"),
        ("A", "int8 a", "expected the name of a message type"),
        ("std_msgs/Bool", "int8 data", "a message type std_msgs/Bool already, with other fields"),
    ],
)
def test_a_wrong_definition_changes_nothing(name, definition, message):
    types = MessageTypes(use_ros=False)

    with pytest.raises(MessageError) as error:
        types.add(name, definition)

    assert message in str(error.value)
    if name == "my_plugins/A":
        with pytest.raises(MessageError, match="no message type"):
            types.get(name)


def test_an_added_type_may_contain_types_of_ros():
    types = MessageTypes()

    route = types.add("my_plugins/Route", "nav_msgs/Path path")

    for name in ("nav_msgs/Path", "geometry_msgs/PoseStamped", "geometry_msgs/Point"):
        assert types.get(name) is messages.get(name)
    assert type(route().path) is messages.get("nav_msgs/Path")


def test_adding_the_same_type_again_gives_the_same_class():
    types = MessageTypes(use_ros=False)

    assert types.add("a/B", "int8 a") is types.add("a/B", "int8 a  # the same")
    assert messages.add("std_msgs/Bool", "bool data") is messages.get("std_msgs/Bool")


def test_types_of_a_python_package_are_in_its_folder_msg(tmp_path, monkeypatch):
    folder = tmp_path / "pallet_plugins" / "msg"
    folder.mkdir(parents=True)
    (tmp_path / "pallet_plugins" / "__init__.py").touch()
    (folder / "Pallet.msg").write_text("Crate[] crates")
    (folder / "Crate.msg").write_text("float64 mass")
    (folder / "Wrong.msg").write_text("float64 mass\nfloat64 mass")
    monkeypatch.syspath_prepend(tmp_path)

    for types in (MessageTypes(use_ros=False), messages):
        crate = types.get("pallet_plugins/Crate")(mass=2.0)
        pallet = types.get("pallet_plugins/Pallet")(crates=[crate])
        assert len(serialized(pallet)) == 12
        with pytest.raises(MessageError, match='did you mean "pallet_plugins/Pallet"'):
            types.get("pallet_plugins/Palet")
        with pytest.raises(MessageError, match=r"Wrong\.msg:2: expected each name once"):
            types.get("pallet_plugins/Wrong")
