"""Messages that lie about the length of an array of empty items, of types made by genpy."""

import importlib
import struct
import tracemalloc
from io import BytesIO

import genmsg
import genpy
import pytest
import rospy
from genpy.generator import msg_generator
from rospy.impl import tcpros_base
from std_msgs.msg import Empty

from flatland_server.messages.wire_form import serialized
from flatland_server.ros.raw_messages import RawMessage
from flatland_server.ros.rospy_patches import install

TYPES = {
    "Uuid": "uint8[16] uuid",
    "Lists": "Uuid[] uuids\nstd_msgs/Empty[] none\nUuid[2] two",
    "Nested": "string name\nLists[] lists",
    "Path": "Header header\ngeometry_msgs/Pose[] poses",
}
USED = {
    "geometry_msgs/Point": "float64 x\nfloat64 y\nfloat64 z",
    "geometry_msgs/Quaternion": "float64 x\nfloat64 y\nfloat64 z\nfloat64 w",
    "geometry_msgs/Pose": "Point position\nQuaternion orientation",
    "std_msgs/Empty": "",
    "std_msgs/Header": "uint32 seq\ntime stamp\nstring frame_id",
}
LIE = 200_000
"""More items than a message may have; few enough for a test of code that believes it."""


@pytest.fixture(scope="module")
def types(tmp_path_factory):
    """The module of a package that genpy has made."""
    folder = tmp_path_factory.mktemp("packages")
    (folder / "liars" / "msg").mkdir(parents=True)
    (folder / "liars" / "__init__.py").touch()
    context = genmsg.MsgContext.create_default()
    for name, text in USED.items():
        genmsg.msg_loader.load_msg_from_string(context, text, name)
    for name, text in TYPES.items():
        spec = genmsg.msg_loader.load_msg_from_string(context, text, f"liars/{name}")
        code = "\n".join(msg_generator(context, spec, {}))
        (folder / "liars" / "msg" / f"_{name}.py").write_text(code)
    imports = "".join(f"from ._{name} import *\n" for name in TYPES)
    (folder / "liars" / "msg" / "__init__.py").write_text(imports)
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(folder)
        yield importlib.import_module("liars.msg")


def lies(types):
    """Bytes that say that they have more items than they have, by type."""
    lie, nothing = struct.pack("<I", LIE), struct.pack("<I", 0)
    return [
        (types.Lists, lie + nothing + bytes(32)),
        (types.Lists, nothing + lie + bytes(32)),
        (types.Nested, nothing + struct.pack("<I", 1) + nothing + lie + bytes(32)),
    ]


def read(deserialize, message_type, data):
    """The messages that rospy reads of a connection's bytes."""
    buffer, found = BytesIO(), []
    buffer.write(struct.pack("<I", len(data)) + data)
    deserialize(buffer, found, message_type, queue_size=None)
    return found


@pytest.fixture(params=["rospy.msg", "tcpros_base"])
def deserialize(request, unpatched_rospy):
    """The functions by which rospy reads messages: of calls of services, and all else."""
    install()
    owner = rospy.msg if request.param == "rospy.msg" else tcpros_base
    return owner.deserialize_messages


@pytest.mark.parametrize("number", range(3))
def test_a_false_length_is_refused_before_memory_is_allocated(types, deserialize, number):
    message_type, data = lies(types)[number]
    tracemalloc.start()
    try:
        with pytest.raises(genpy.DeserializationError, match="expected"):
            read(deserialize, message_type, data)
        assert tracemalloc.get_traced_memory()[1] < 1_000_000
    finally:
        tracemalloc.stop()


def test_messages_with_true_lengths_are_read_unchanged(types, deserialize):
    uuids = [types.Uuid(bytes([number] * 16)) for number in range(2)]
    lists = types.Lists(uuids=uuids, none=[Empty(), Empty()])
    nested = types.Nested("ä", [lists, types.Lists()])
    for message in (lists, nested):
        [found] = read(deserialize, type(message), serialized(message))
        assert found == message
        assert type(found) is type(message)


def test_other_types_are_read_by_their_own_code(types, deserialize, monkeypatch):
    monkeypatch.setattr(types.Path, "deserialize", lambda self, data: data)
    path = serialized(types.Path())

    assert read(deserialize, types.Path, path) == [path]
    [raw] = read(deserialize, RawMessage, path)
    assert raw._buff == path


def test_false_lengths_in_raw_messages_are_refused_too(types):
    raw = RawMessage()
    raw._connection_header = {"type": "liars/Lists"}
    raw._buff = lies(types)[1][1]

    with pytest.raises(Exception, match="expected 100000 messages within a message or fewer"):
        len(raw.none)
