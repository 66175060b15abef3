"""Message types and times of our own, against ROS's."""

import copy
import dataclasses
import inspect
import pickle
import random
import string
import struct
import tracemalloc
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import genpy
import numpy as np
import pytest
from without_ros import run_without_ros

from flatland_server import LocalTransport, MessageError, Node, messages
from flatland_server.messages import message, message_types, service_types, times
from flatland_server.messages.definition import NUMBERS, FieldType
from flatland_server.messages.message_types import MessageTypes, deserialized
from flatland_server.messages.standard_definitions import standard_definitions
from flatland_server.messages.wire_form import serialized

FLATLAND_MSGS = Path(__file__).resolve().parents[3] / "flatland_msgs" / "msg"
NAMES = [
    *(name for name in standard_definitions() if not name.startswith("ackermann_msgs/")),
    *(f"flatland_msgs/{file.stem}" for file in sorted(FLATLAND_MSGS.glob("*.msg"))),
]
OURS = MessageTypes(use_ros=False)
RANGES = {
    **{"bool": (0, 1), "byte": (-128, 127), "char": (0, 255)},
    **{f"int{bits}": (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1) for bits in (8, 16, 32, 64)},
    **{f"uint{bits}": (0, 2**bits - 1) for bits in (8, 16, 32, 64)},
}


class RandomValues:
    """Random messages of a set of types, equal for equal seeds."""

    def __init__(self, types: MessageTypes, seed: str) -> None:
        self.types = types
        self.random = random.Random(seed)

    def message(self, name: str) -> Any:
        definition = OURS._definition(name)
        values = {field: self.value(kind) for field, kind in definition.fields}
        return self.types.get(name)(**values)

    def value(self, kind: FieldType) -> Any:
        if not kind.is_array:
            return self.scalar(kind.base)
        length = self.random.randrange(4) if kind.length is None else kind.length
        values = [self.scalar(kind.base) for _ in range(length)]
        return bytes(values) if kind.base in ("uint8", "char") else values

    def scalar(self, base: str) -> Any:
        if base in RANGES:
            number = self.random.randint(*RANGES[base])
            return bool(number) if base == "bool" else number
        if base in NUMBERS:
            return np.float32(self.random.gauss(0, 1e3)).item()
        if base == "string":
            return "".join(self.random.choices(string.printable + "äöü→", k=5))
        if base == "time":
            return self.types.Time(self.random.randrange(2**32), self.random.randrange(10**9))
        if base == "duration":
            return self.types.Duration(self.random.randint(-99, 99), self.random.randrange(10**9))
        return self.message(base)


def plain(value: Any) -> Any:
    """A message as tuples of plain values."""
    if hasattr(value, "nsecs"):
        return type(value).__name__, value.secs, value.nsecs
    if hasattr(value, "__slots__"):
        return tuple(plain(getattr(value, name)) for name in sorted(value.__slots__))
    return tuple(map(plain, value)) if isinstance(value, (list, tuple)) else value


@pytest.mark.parametrize("name", NAMES)
def test_a_type_is_that_of_ros(name):
    ours, ros = OURS.get(name), messages.get(name)

    assert issubclass(ros, genpy.Message)
    assert not issubclass(ros, message.Message)
    assert (ours._type, ours._md5sum) == (ros._type, ros._md5sum)
    assert list(ours.__slots__) == ros.__slots__
    assert ours._slot_types == ros._slot_types
    assert ours._has_header == ros._has_header
    constants = [c.name for c in OURS._definition(name).constants]
    assert {c: getattr(ours, c) for c in constants} == {c: getattr(ros, c) for c in constants}
    public = {name for name, _ in inspect.getmembers(ros) if name[0].isupper()}
    assert public - set(ros.__slots__) == set(constants)
    assert plain(ours()) == plain(ros())
    for field in ros.__slots__:  # the defaults
        assert type(getattr(ours(), field)).__name__ == type(getattr(ros(), field)).__name__


def test_types_missing_in_debian_have_the_published_md5sums():
    """As genmsg computes them of the files of ackermann_msgs 1.0.2."""
    drive, stamped = map(
        OURS.get, ("ackermann_msgs/AckermannDrive", "ackermann_msgs/AckermannDriveStamped")
    )
    assert drive._md5sum == "3512e91b48d69674a0e86fadf1ea8231"
    assert stamped._md5sum == "1fd5d7f58889cefd44d29f6653240d0c"


@pytest.mark.parametrize("name", NAMES)
def test_messages_are_serialized_as_by_ros(name):
    for seed in range(3):
        ours = RandomValues(OURS, f"{name}{seed}").message(name)
        ros = RandomValues(message_types.TYPES, f"{name}{seed}").message(name)

        data = serialized(ros)
        assert serialized(ours) == data
        received = OURS.get(name)().deserialize(data)
        by_ros = type(ros)().deserialize(data)
        assert plain(received) == plain(by_ros)
        read = deserialized(type(ros), data)
        assert (type(read), plain(read)) == (type(ros), plain(by_ros))
        assert serialized(received) == data
        assert received == ours or "nan" in repr(ours)


@pytest.mark.parametrize("name", ["sensor_msgs/PointCloud2", "flatland_msgs/Collisions"])
def test_the_full_text_has_all_types_that_a_type_uses(name):
    from genpy.dynamic import generate_dynamic

    generated = generate_dynamic(name, OURS.get(name)._full_text)

    assert generated[name]._md5sum == OURS.get(name)._md5sum


def test_a_message_is_made_of_all_fields_or_of_some_by_keyword():
    vector = OURS.get("geometry_msgs/Vector3")

    assert vector(1.0, 2.0, 3.0) == vector(x=1.0, y=2.0, z=3.0)
    assert vector(y=2.0) == vector(0.0, 2.0, 0.0) != vector()
    assert str(vector(y=2.0)) == repr(vector(y=2.0)) == "Vector3(x=0.0, y=2.0, z=0.0)"
    assert dataclasses.asdict(vector(y=2.0)) == {"x": 0.0, "y": 2.0, "z": 0.0}
    assert dataclasses.replace(vector(y=2.0), x=1.0) == vector(1.0, 2.0, 0.0)
    assert list(inspect.signature(vector).parameters) == ["x", "y", "z"]
    with pytest.raises(AttributeError):
        vector().w = 1.0
    with pytest.raises(MessageError, match=r"all fields \(x, y, z\).* found 2"):
        vector(1.0, 2.0)


def test_arrays_may_be_numpys():
    scan = OURS.get("sensor_msgs/LaserScan")
    values = [0.5, float("inf"), 2.25]

    for dtype in (np.float32, np.float64):
        array = scan(ranges=np.array(values, dtype))
        assert serialized(array) == serialized(scan(ranges=values))
        assert array == scan(ranges=tuple(values))
    cloud = OURS.get("sensor_msgs/PointCloud2")
    assert cloud().deserialize(serialized(cloud(data=np.arange(4, dtype=np.uint8)))).data == (
        b"\0\1\2\3"
    )
    grid = OURS.get("nav_msgs/OccupancyGrid")
    assert grid().deserialize(serialized(grid(data=np.array([-1, 100])))).data == (-1, 100)


def test_messages_can_be_copied_and_pickled(monkeypatch):
    monkeypatch.setattr(message_types, "get", OURS.get)
    odometry = RandomValues(OURS, "copy").message("nav_msgs/Odometry")

    for made in (copy.deepcopy(odometry), pickle.loads(pickle.dumps(odometry))):
        assert made == odometry
        assert made.pose is not odometry.pose


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("Twist", 'no message type "Twist" (did you mean "geometry_msgs/Twist"?)'),
        ("geom_msgs/Twist", '(did you mean "geometry_msgs/Twist"?)'),
        ("sensor_msgs/LaserScna", '(did you mean "sensor_msgs/LaserScan"?)'),
        ("flatland_msgs/Collison", '(did you mean "flatland_msgs/Collision"?)'),
        ("unknown/Kind", 'no message type "unknown/Kind"; messages.add(name, definition) adds one'),
        ("a/b/c", 'expected the name of a message type, such as "geometry_msgs/Twist"'),
        (None, "expected the name of a message type"),
    ],
)
@pytest.mark.parametrize("types", [OURS, messages], ids=["ours", "ros"])
def test_an_unknown_type_is_refused(types, name, message):
    with pytest.raises(MessageError) as error:
        types.get(name)

    assert message in str(error.value)


@pytest.mark.parametrize(
    ("name", "fields", "message"),
    [
        ("std_msgs/Header", {"frameid": ""}, 'no field "frameid" (did you mean "frame_id"?)'),
        ("std_msgs/Header", {"frame_id": 3}, "frame_id: expected string, found 3"),
        ("std_msgs/Header", {"stamp": 3}, 'stamp: expected an object with "secs", found 3'),
        ("std_msgs/UInt8", {"data": -1}, "data: expected uint8, found -1"),
        ("std_msgs/Time", {"data": times.Duration(-1)}, "data.secs: expected uint32, found -1"),
        ("geometry_msgs/Twist", {"linear": 1}, 'linear: expected an object with "x", found 1'),
        (
            "geometry_msgs/PoseWithCovariance",
            {"covariance": [0.0]},
            "covariance: expected float64[36]",
        ),
        ("sensor_msgs/LaserScan", {"ranges": ["far"]}, "ranges: expected float32[], found ['far']"),
        ("sensor_msgs/Image", {"data": 7}, "data: expected uint8[], found 7"),
        ("sensor_msgs/JointState", {"name": [1]}, "name: expected string[], found [1]"),
        (
            "visualization_msgs/MarkerArray",
            {"markers": [OURS.get("visualization_msgs/Marker")(points=[4])]},
            'markers[0].points[0]: expected an object with "x", found 4',
        ),
    ],
)
def test_a_wrong_value_is_named(name, fields, message):
    with pytest.raises(MessageError) as error:
        serialized(OURS.get(name)(**fields))

    assert str(error.value).startswith(name)
    assert message in str(error.value)


def test_data_that_is_too_short_is_refused():
    data = serialized(OURS.get("sensor_msgs/LaserScan")(ranges=[1.0, 2.0]))

    for length in range(len(data)):
        with pytest.raises(MessageError, match=f"found {length}"):
            OURS.get("sensor_msgs/LaserScan")().deserialize(data[:length])


@pytest.mark.parametrize("length", [2**32 - 1, 2**31, 100_001])
@pytest.mark.parametrize("is_ros", [False, True], ids=["ours", "ros"])
@pytest.mark.parametrize(
    "name", ["nav_msgs/Path", "tf2_msgs/TFMessage", "sensor_msgs/JointState", "unknown/Nothings"]
)
def test_a_length_without_data_makes_nothing(name, is_ros, length):
    types = message_types.TYPES if is_ros else OURS
    types.add("unknown/Nothing", "")
    types.add("unknown/Nothings", "Nothing[] items")
    kind = types.get(name)
    head = serialized(kind())[: -4 if name != "sensor_msgs/JointState" else -16]
    data = head + struct.pack("<I", length)

    tracemalloc.start()
    try:
        with pytest.raises(MessageError, match=f"{name}: expected "):
            deserialized(kind, data)
        if not is_ros:
            with pytest.raises(MessageError):
                kind().deserialize(data)
        assert tracemalloc.get_traced_memory()[1] < 200_000
    finally:
        tracemalloc.stop()


def test_a_message_of_few_bytes_may_be_large():
    points = OURS.get("sensor_msgs/PointCloud")(
        points=[OURS.get("geometry_msgs/Point32")()] * 100_001
    )

    assert len(deserialized(type(points), serialized(points)).points) == 100_001


def test_requests_and_responses_are_read_by_their_definitions():
    for name in ("flatland_msgs/SpawnModel", "flatland_msgs/Step", "std_srvs/SetBool"):
        for kind in service_types.get(name)[1:3]:
            assert deserialized(kind, serialized(kind())) == kind()


def test_the_name_of_a_type_imports_only_packages_with_messages(tmp_path, monkeypatch):
    """Only types made by genpy are found, also in a package that catkin relays to its source."""
    generated = Path(messages.get("std_msgs/Bool").__module__.replace(".", "/") + ".py")
    generated = (
        (Path(genpy.__file__).parents[1] / generated).read_text().replace("std_msgs", "carts")
    )
    relayed, plain_package = tmp_path / "carts", tmp_path / "boats"
    for folder in (relayed / "msg", plain_package / "msg"):
        folder.mkdir(parents=True)
        ran = "from pathlib import Path\nPath(__file__).with_name('ran').touch()\n"
        (folder.parent / "__init__.py").write_text(ran)
    (relayed / "msg" / "_Bool.py").write_text(generated)
    (relayed / "msg" / "__init__.py").write_text("from ._Bool import *")
    (plain_package / "msg" / "__init__.py").write_text("Bool = 1")
    monkeypatch.syspath_prepend(tmp_path)

    with pytest.raises(MessageError, match="no message type"):
        messages.get("boats/Bool")
    with pytest.raises(MessageError, match="expected the name of a message type"):
        messages.get("boats.msg")
    with pytest.raises(MessageError, match="no service type"):
        service_types.get("boats/Bool")
    with pytest.raises(MessageError, match="no message type"):
        messages.get("carts/Boool")
    assert not list(tmp_path.rglob("ran"))
    assert issubclass(messages.get("carts/Bool"), genpy.Message)


def test_threads_get_the_same_class():
    for _ in range(20):
        types = MessageTypes(use_ros=False)
        with ThreadPoolExecutor(8) as pool:
            classes = set(pool.map(types.get, ["visualization_msgs/MarkerArray"] * 8))

        assert len(classes) == 1


def test_a_node_takes_a_type_by_its_name():
    transport = LocalTransport()
    node = Node(transport)
    received = []

    node.subscribe("/a", "std_msgs/Bool", received.append)
    node.advertise("/b", "std_msgs/Bool")
    transport.send("/a", messages.get("std_msgs/Bool")(True))
    transport.process()

    assert [message.data for message in received] == [True]
    with pytest.raises(MessageError, match='did you mean "std_msgs/Bool"'):
        node.advertise("/c", "std_msgs/Boool")
    with pytest.raises(MessageError):
        node.subscribe("/c", "std_msgs/Boool", received.append)
    assert transport.topics == {"/b"}


def test_the_definitions_of_flatland_msgs_are_packaged():
    from flatland_server.messages.message_types import _DEFINITIONS

    packaged = {file.name: file.read_text() for file in _DEFINITIONS.glob("flatland_msgs/*.msg")}

    assert packaged == {file.name: file.read_text() for file in FLATLAND_MSGS.glob("*.msg")}
    assert packaged


@pytest.mark.slow
def test_without_ros_the_types_are_ours():
    print_types = """
from flatland_server import header, messages, ros_time
for name in ("sensor_msgs/LaserScan", "flatland_msgs/Collisions"):
    print(messages.get(name)._md5sum, messages.get(name).__mro__[1].__module__)
print(type(ros_time(5)).__module__, repr(header(1_000_000_002, "map")))
"""

    assert run_without_ros(print_types).splitlines() == [
        f"{messages.get('sensor_msgs/LaserScan')._md5sum} flatland_server.messages.message",
        f"{messages.get('flatland_msgs/Collisions')._md5sum} flatland_server.messages.message",
        "flatland_server.messages.times Header(seq=0, stamp=Time(secs=1, nsecs=2), frame_id='map')",
    ]


# Times and durations, against ROS's


@pytest.mark.parametrize("kind", ["Time", "Duration"])
def test_times_are_those_of_ros(kind):
    ours, ros = getattr(times, kind), getattr(genpy, kind)

    for args in ((), (3,), (3, 4), (2, 3_500_000_000), (1.25,), (0, 999_999_999)):
        a, b = ours(*args), ros(*args)
        for method in ("to_sec", "to_nsec", "is_zero", "__str__", "__hash__", "__bool__"):
            assert getattr(a, method)() == getattr(b, method)()
        assert (a.secs, a.nsecs) == (b.secs, b.nsecs)
    assert ours.from_sec(2.75) == ours(2, 750_000_000) != ours(2)
    assert ours(1) < ours(1, 1) <= ours(1, 1) < ours(2) >= ours(1) > ours(0, 5)
    with pytest.raises(TypeError):
        ours(1) < 1.0  # noqa: B015
    with pytest.raises(ValueError, match="whole seconds"):
        ours(1.5, 1)


def test_time_arithmetic_equals_that_of_ros():
    for kit in (times, genpy):
        time, duration = kit.Time, kit.Duration
        assert time(5, 1) - time(3, 2) == duration(1, 999_999_999)
        assert time(5) - duration(0, 1) == time(4, 999_999_999)
        assert time(5) + duration(1, 5) == duration(1, 5) + time(5) == time(6, 5)
        assert duration(1) + duration(2) - duration(0, 1) == duration(2, 999_999_999)
        assert abs(-duration(2)) == duration(1) * 2 == duration(4) / 2 == duration(8) * 0.25
        assert duration(6) / duration(4) == 1.5
        assert duration(7) // duration(4) == 1
        with pytest.raises(TypeError):
            time(1) - duration(2)
