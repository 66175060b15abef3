"""Messages of clients that do not keep to a protocol: each is answered, and the client stays."""

import json
import struct
import tracemalloc

import cbor2
import pytest
from bridge_clients import Client
from test_foxglove import Viewer

from flatland_bridge.graph import BridgeError
from flatland_bridge.rosbridge_form import publisher
from flatland_bridge.sample import Sample
from flatland_server import messages

HUGE = b"\xc4\x82\x1a\x00\x0f\x42\x40\x01"
"""1e1000000 as CBOR's decimal fraction."""
CYCLE = b"\xd8\x1c\x81\xd8\x1d\x00"
"""A list that contains itself, as CBOR."""


def cbor(**fields):
    """A map; bytes are values that are CBOR already."""
    items = (
        cbor2.dumps(key) + (each if isinstance(each, bytes) else cbor2.dumps(each))
        for key, each in fields.items()
    )
    return bytes([0xA0 + len(fields)]) + b"".join(items)


def answered(client, message):
    """The text by which a client is told what is wrong with its message."""
    client.socket.send(message if isinstance(message, (str, bytes)) else json.dumps(message))
    status = client.receive_until(lambda each: each["op"] == "status")
    assert status["level"] == "error"
    assert client.call("/rosapi/nodes")["result"]
    return status["msg"]


SCAN = {"op": "subscribe", "topic": "/scan"}
CALL = {"op": "call_service", "service": "/pause"}
INFINITE, NAN = float("inf"), float("nan")


@pytest.mark.parametrize(
    ("message", "expected"),
    [
        (cbor(**SCAN, throttle_rate=INFINITE), "throttle_rate: expected a whole number from 0"),
        (cbor(**SCAN, throttle_rate=NAN), "throttle_rate: expected a whole number from 0"),
        (cbor(**SCAN, throttle_rate=HUGE), "expected CBOR: expected tags of typed arrays alone"),
        ({**SCAN, "throttle_rate": 1e300}, "throttle_rate: expected a whole number from 0"),
        ({**SCAN, "queue_length": True}, "queue_length: expected a whole number from 0"),
        ({**SCAN, "fragment_size": -1}, "fragment_size: expected a whole number from 0"),
        ({**SCAN, "id": {"a": 1}}, "id: expected text or a number, found {'a': 1}"),
        (cbor(**SCAN, id=CYCLE), "expected CBOR: expected tags of typed arrays alone"),
        (cbor(**SCAN, id=cbor2.dumps(b"\xff")), "id: expected text or a number, found b'"),
        (cbor(**SCAN, id=b"\xf7"), "expected CBOR: expected plain values, found undefined"),
        (cbor(**SCAN, id=b"\x3b" + b"\xff" * 8), "expected CBOR: expected integers of 64 bits"),
        (cbor(op="set_level", level=b"\xd8\x40\x42\x00\x01"), "level: expected text, found array"),
        (cbor(op=CYCLE), "expected CBOR"),
        (b"\x9b\x00\x00\x00\x00\xff\xff\xff\xff", "expected CBOR"),
        (b"\xa1\x01\x02", "expected CBOR"),
        pytest.param(b"\x81" * 300 + b"\x00", "expected CBOR", id="deep CBOR"),
        pytest.param("[" * 900 + "]" * 900, "expected JSON: expected 100 levels", id="deep"),
        ('{"op": "subscribe", "topic": "\\ud800"}', "expected JSON"),
        ({"op": "subscribe", "topic": "/" + "a" * 300}, "expected a name as topic"),
        ({"op": ["subscribe"]}, "op: expected text"),
        ({"op": "fragment", "id": 1, "num": 1e400, "total": 2, "data": ""}, "expected JSON"),
        ({"op": "fragment", "id": 1, "num": 3, "total": 2, "data": ""}, "num: expected less"),
        ({"op": "fragment", "id": 1, "num": 0, "total": 1, "data": 7}, "data: expected text"),
        ({"op": "advertise", "topic": "/x", "type": 7}, "expected the name of a type"),
        ("{", "expected JSON"),
        ("[1]", "expected an object"),
        ({"op": "subscibe"}, 'did you mean "subscribe"'),
        ({"op": "subscribe", "topic": "a b"}, "expected a name as topic"),
        ({**SCAN, "type": "std_msgs/String"}, "LaserScan, not"),
        ({**SCAN, "throttle_rate": "x"}, "throttle_rate: expected"),
        ({"op": "advertise", "topic": "/x", "type": "no/Type"}, "there is no message type"),
        ({"op": "publish", "topic": "/cmd_vle", "msg": {}}, 'did you mean "/cmd_vel"'),
        ({"op": "publish", "topic": "/scan", "msg": {}}, "published by the simulation"),
        ({"op": "publish", "topic": "/cmd_vel", "msg": {"linaer": {}}}, 'mean "linear"'),
        ({"op": "publish", "topic": "/cmd_vel", "msg": {"linear": {"x": "1"}}}, "x: expected flo"),
        ({"op": "fragment", "id": 1}, "num: expected a whole number"),
        ({"op": "set_level", "level": 3}, "level: expected"),
    ],
)
def test_a_wrong_message_is_answered_and_the_client_stays(client, message, expected):
    assert expected in answered(client, message)


@pytest.mark.parametrize("size", ["x", 0.5])
def test_a_call_with_an_answer_that_has_no_form_fails(client, size):
    client.send("call_service", service="/pause", id="7", fragment_size=size)

    answer = client.receive_until(lambda each: each["op"] == "service_response")
    assert (answer["id"], answer["result"]) == ("7", False)
    assert "fragment_size: expected a whole number from 0" in answer["values"]


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (cbor(steps=HUGE), "expected tags of typed arrays alone, found the tag 4"),
        (cbor(steps=b"\xfb\x7f\xf0" + bytes(6)), "steps: expected int32 (-2147483648 to 214"),
        (cbor(steps=2**40), "steps: expected int32 (-2147483648 to 2147483647), found 1099511"),
        (cbor(expect=[{"topic": "/scan"}] * 3, timeout=b"\xd8\x1d\x00"), "found the tag 29"),
    ],
)
def test_a_call_with_a_wrong_number_is_refused(client, arguments, expected):
    call = cbor(op="call_service", id="1", service="/step", args=arguments)
    client.socket.send(call)

    answer = client.receive()

    assert expected in str(answer.get("values", answer.get("msg")))
    assert client.call("/step", steps=1)["values"]["success"]


@pytest.mark.parametrize(
    ("kind", "value", "expected"),
    [
        ("std_msgs/UInt8", 1e30, "std_msgs/UInt8: data: expected uint8 (0 to 255), found 1e+30"),
        ("std_msgs/UInt8", 300, "data: expected uint8 (0 to 255), found 300"),
        ("std_msgs/Int64", 2**63, "data: expected int64 (-9223372036854775808 to"),
        ("std_msgs/Float32", 1e39, "data: expected float32 (up to 3.40282e+38), found 1e+39"),
        ("std_msgs/Time", {"secs": -1}, "data: expected time (secs from 0 to 4294967295), found"),
        ("std_msgs/Time", {"secs": 2**32}, "data: expected time (secs from 0 to 4294967295)"),
        ("std_msgs/Duration", {"secs": 2**31}, "data: expected duration (secs from -21474836"),
        ("std_msgs/UInt8MultiArray", 600_000_000, "data: expected uint8[] (0 to 255), found 6000"),
        ("std_msgs/UInt8MultiArray", [256], "data: expected uint8[] (0 to 255), found [256]"),
        ("std_msgs/Int16MultiArray", [1, 40000], "data: expected int16 (-32768 to 32767), found"),
        ("nav_msgs/Path", [{}] * 30_000, "poses: expected 100000 messages within a message or"),
    ],
)
@pytest.mark.parametrize("compression", ["none", "cbor", "cbor-raw"])
def test_a_wrong_value_is_refused_to_its_publisher(
    server, client, kind, value, expected, compression
):
    field = "poses" if kind == "nav_msgs/Path" else "data"
    client.send("advertise", topic="/any", type=kind)
    subscriber = Client(server).subscribed("/any", compression=compression)

    message = {"op": "publish", "topic": "/any", "msg": {field: value}}
    assert expected in answered(client, message)

    client.send("publish", topic="/any", msg={})
    assert subscriber.next_of("/any") is not None


@pytest.mark.parametrize("compression", ["none", "cbor", "cbor-raw"])
def test_a_message_that_cannot_be_encoded_says_so(compression):
    kind = messages.get("std_msgs/UInt8")
    encode = publisher(compression, 0)

    with pytest.raises(BridgeError, match='a message of "/x" cannot be sent: '):
        encode(Sample("/x", 0, kind, kind(data="x")))

    assert encode(Sample("/x", 0, kind, kind(data=1)))


def test_bytes_of_one_client_reach_another_as_text(server, client):
    other = Client(server)
    other.send("advertise_service", service="/add", type="std_srvs/SetBool")
    other.call("/rosapi/nodes")

    client.socket.send(cbor2.dumps({"op": "call_service", "service": "/add", "args": {"a": b"\0"}}))
    asked = other.receive()
    assert asked["args"] == {"a": "AA=="}
    values = {"b": b"\1", "c": cbor2.CBORTag(85, struct.pack("<f", 0.5))}
    answer = {"op": "service_response", "id": asked["id"], "values": values, "result": True}
    other.socket.send(cbor2.dumps(answer))

    answer = client.receive()
    assert answer["values"] == {"b": "AQ==", "c": [0.5]}


@pytest.mark.parametrize(
    ("message", "expected"),
    [
        ({"op": {}}, "op: expected text"),
        ([1], "expected an object, found [1]"),
        ({"op": "subscribe"}, "subscriptions: expected an array, found None"),
        ({"op": "subscribe", "subscriptions": [7]}, "subscriptions: expected objects, found 7"),
        ({"op": "subscribe", "subscriptions": [{"id": 2**32}]}, "id: expected a whole number"),
        ({"op": "subscribe", "subscriptions": [{"id": 1, "channelId": []}]}, "channelId: expec"),
        ({"op": "unsubscribe", "subscriptionIds": [{}]}, "subscriptionIds: expected a whole"),
        ({"op": "unadvertise", "channelIds": [1e300]}, "channelIds: expected a whole number"),
        ({"op": "advertise", "channels": [{"id": "x" * 99}]}, "id: expected a whole number"),
        ({"op": "advertise", "channels": [{"id": 1, "topic": {}}]}, "expected a name as topic"),
        ({"op": "subscribe", "subscriptions": [{"id": 1, "channelId": 9999}]}, "no channel 9999"),
        ({"op": "fetch"}, "there is no operation"),
        pytest.param("[" * 900 + "]" * 900, "expected JSON: expected 100 levels", id="deep"),
        ("{", "expected JSON"),
        (b"\x01\x09\x00\x00\x00abc", "channel 9 is not advertised"),
        (b"\x01", "does not follow the protocol"),
    ],
)
def test_a_wrong_message_of_foxglove_is_answered_and_the_viewer_stays(server, message, expected):
    viewer = Viewer(server)
    viewer.socket.send(message if isinstance(message, (str, bytes)) else json.dumps(message))

    assert expected in viewer.receive_text("status")["message"]
    assert json.loads(viewer.call("/pause", "json", b"{}")) == {}


@pytest.mark.parametrize(
    ("service", "payload", "expected"),
    [
        ("/spawn_entities", b"\xff" * 4, "SpawnEntitiesRequest: expected 382252089259 bytes"),
        ("/spawn_model", b"\xff" * 40, "expected 4294967299 bytes or more"),
        ("/step", b"\1\0\0\0" + b"\xff" * 4, "StepRequest: expected"),
        ("/delete_model", b"\1\0\0\0\xff", "expected UTF-8, found b'\\xff'"),
    ],
)
def test_a_length_is_not_believed(server, service, payload, expected):
    viewer = Viewer(server)
    tracemalloc.start()
    try:
        number = viewer.services[service]["id"]
        viewer.socket.send(struct.pack("<BIII", 2, number, 7, 4) + b"ros1" + payload)
        assert expected in viewer.receive_text("serviceCallFailure")["message"]
        assert tracemalloc.get_traced_memory()[1] < 5_000_000
    finally:
        tracemalloc.stop()
        viewer.socket.close()


@pytest.fixture
def trap(tmp_path, monkeypatch):
    """A Python package without messages; running any of it is a mistake."""
    folder = tmp_path / "a_trap"
    for name in ("", "msg", "srv"):
        (folder / name).mkdir(exist_ok=True)
        (folder / name / "__init__.py").write_text("open(__file__ + '.ran', 'w').close()")
    (folder / "msg" / "X.py").touch()
    monkeypatch.syspath_prepend(tmp_path)
    return folder


@pytest.mark.parametrize("name", ["{}/X", "{}/msg/X", "{}.msg/X", "{}.msg", "{}/msg", "../{}/X"])
def test_the_name_of_a_type_imports_no_module(server, client, trap, name):
    name = name.format(trap.name)

    client.send("advertise", topic="/x", type=name)
    client.send("subscribe", topic="/scan", type=name)
    for service in ("message_details", "service_request_details", "service_response_details"):
        assert not client.call(f"/rosapi/{service}", type=name)["result"]
    viewer = Viewer(server)
    channel = {"id": 1, "topic": "/x", "encoding": "ros1", "schemaName": name}
    viewer.send(op="advertise", channels=[channel])
    assert "message type" in viewer.receive_text("status")["message"]

    assert list(trap.rglob("*.ran")) == []
