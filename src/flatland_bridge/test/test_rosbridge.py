"""The rosbridge protocol: topics, services, fragments, errors."""

import base64
import json
import struct
import subprocess
import sys

import numpy as np
import pytest
from bridge_clients import Client, replace_service, running
from test_foxglove import Viewer


def test_a_client_sees_topics_types_and_services(client):
    found = client.call("/rosapi/topics")["values"]
    types = dict(zip(found["topics"], found["types"]))

    assert types["/scan"] == "sensor_msgs/LaserScan"
    assert types["/cmd_vel"] == "geometry_msgs/Twist"
    assert types["/flatland_server/debug/walls"] == "flatland_msgs/Walls"
    assert client.call("/rosapi/topic_type", topic="/tf")["values"]["type"] == "tf2_msgs/TFMessage"
    assert "/spawn_model" in client.call("/rosapi/services")["values"]["services"]
    kind = client.call("/rosapi/service_type", service="/step")["values"]["type"]
    details = client.call("/rosapi/service_request_details", type=kind)["values"]["typedefs"]
    assert details[0]["fieldnames"] == ["steps", "expect", "timeout"]
    assert details[0]["fieldarraylen"] == [-1, 0, -1]
    raw = client.call("/rosapi/topics_and_raw_types")["values"]
    assert len(raw["typedefs_full_text"]) == len(raw["topics"])


def test_a_client_drives_the_robot_and_reads_its_scan(client):
    client.subscribed("/scan").subscribed("/odometry/ground_truth", queue_length=1)
    client.send("publish", topic="/cmd_vel", msg={"linear": {"x": 1.0}})

    assert client.call("/step", steps=200)["values"]["success"]

    scan = client.next_of("/scan")
    assert len(scan["ranges"]) == 401
    assert scan["ranges"][0] is None  # infinity: nothing is there
    assert scan["ranges"][200] == pytest.approx(5.0, abs=0.1)
    client.call("/step", steps=1)
    odometry = client.next_of("/odometry/ground_truth")
    while odometry["header"]["stamp"] != {"secs": 1, "nsecs": 0}:
        odometry = client.next_of("/odometry/ground_truth")
    assert odometry["pose"]["pose"]["position"]["x"] == pytest.approx(1.0, abs=0.02)


def test_cbor_has_typed_arrays_and_cbor_raw_the_bytes(server, client):
    client.subscribed("/scan", compression="cbor").call("/step", steps=20)
    tagged = client.next_of("/scan")["ranges"]
    ranges = np.frombuffer(tagged.value, np.float32)
    assert (tagged.tag, len(ranges)) == (85, 401)
    assert ranges[0] == np.inf

    raw = Client(server)
    raw.subscribed("/scan", compression="cbor-raw").call("/step", steps=20)
    message = raw.next_of("/scan")
    assert len(message["bytes"]) > 4 * 401
    assert (message["secs"], message["nsecs"]) == (0, 100_000_000)


def test_a_latched_message_reaches_each_new_client(server, client):
    for each in (client, Client(server)):
        walls = each.subscribed("/flatland_server/debug/walls").next_of(
            "/flatland_server/debug/walls"
        )
        assert walls["layers"][0]["segments"] == [-5, 5, 5, 5, 5, -5, 5, 5]


def test_long_messages_are_fragmented_in_both_directions(client):
    client.subscribed("/scan", fragment_size=500).call("/step", steps=20)
    parts = [client.receive_until(lambda each: each["op"] == "fragment")]
    while len(parts) < parts[0]["total"]:
        parts.append(client.receive_until(lambda each: each["op"] == "fragment"))
    assert all(len(part["data"]) <= 500 for part in parts)
    message = json.loads("".join(part["data"] for part in sorted(parts, key=lambda p: p["num"])))
    assert (message["op"], message["topic"]) == ("publish", "/scan")

    text = json.dumps({"op": "call_service", "id": "x", "service": "/rosapi/nodes"})
    for number, begin in reversed(list(enumerate(range(0, len(text), 20)))):
        data, total = text[begin : begin + 20], -(-len(text) // 20)
        client.send("fragment", id="f", num=number, total=total, data=data)
    response = client.receive_until(lambda each: each["op"] == "service_response")
    assert response["values"] == {"nodes": ["/flatland_server"]}


def test_fragments_of_two_messages_with_one_id_are_told_apart(client):
    client.send("fragment", id="f", num=4, total=5, data="x")
    for number, data in enumerate(('{"op": "call_service", ', '"service": "/rosapi/topics"}')):
        client.send("fragment", id="f", num=number, total=2, data=data)

    assert client.receive_until(lambda each: each["op"] == "service_response")["result"]


def test_fragments_have_a_smallest_size(client):
    client.subscribed("/scan", fragment_size=1).call("/step", steps=20)
    first = client.receive_until(lambda each: each["op"] == "fragment")

    assert len(first["data"]) == 200


def test_a_failed_call_says_why(client):
    assert "no service" in client.call("/nope")["values"]
    assert "expected int32" in client.call("/step", steps="x")["values"]
    moved = client.call("/move_model", name="robto")
    assert moved["values"]["message"].startswith('ModelError: there is no model "robto" (did you')


def test_models_come_and_go_by_services(client):
    where = {"x": 2.0, "y": 1.0, "theta": 0.0}
    spawned = client.call("/spawn_model", yaml_path="robot.model.yaml", name="two", ns="two")
    assert spawned["values"]["success"], spawned
    assert "/two/scan" in client.call("/rosapi/topics")["values"]["topics"]
    assert client.call("/move_model", name="two", pose=where)["values"]["success"]
    client.subscribed("/flatland_server/model_states").call("/step", steps=1)
    states = client.next_of("/flatland_server/model_states")["models"]
    assert {"x": 2.0, "y": 1.0, "theta": 0.0} in [state["pose"] for state in states]
    assert client.call("/delete_model", name="two")["values"]["success"]
    assert client.call("/undo")["values"]["message"] == "Undone: Delete two"
    assert "/two/scan" in client.call("/rosapi/topics")["values"]["topics"]
    assert client.call("/redo")["values"]["success"]
    assert "/two/scan" not in client.call("/rosapi/topics")["values"]["topics"]
    client.call("/step", steps=10)
    assert client.call("/reset", restart_time=True)["values"]["success"]
    assert client.call("/rosapi/get_time")["values"]["time"] == {"secs": 0, "nsecs": 0}


def test_diagnostics_tell_how_the_simulation_goes(client):
    client.subscribed("/diagnostics")
    [status] = client.next_of("/diagnostics")["status"]
    assert (status["name"], status["level"]) == ("flatland_server: simulation", 0)


def test_clients_offer_services_to_each_other(server, client):
    other = Client(server)
    other.send("advertise_service", service="/add", type="std_srvs/SetBool")
    other.call("/rosapi/nodes")

    client.send("call_service", id="7", service="/add", args={"data": True})
    asked = other.receive()
    assert asked["args"] == {"data": True}
    other.send("service_response", id=asked["id"], service="/add", values={"ok": 1}, result=True)
    answer = client.receive()
    assert (answer["id"], answer["values"], answer["result"]) == ("7", {"ok": 1}, True)

    client.send("call_service", id="8", service="/add", args={})
    other.receive()
    other.socket.close()
    assert client.receive()["result"] is False


def test_bytes_are_base64_in_json(client):
    client.send("advertise", topic="/image", type="sensor_msgs/Image")
    client.subscribed("/image")
    data = base64.b64encode(b"\x00\xff").decode()
    client.send("publish", topic="/image", msg={"height": 1, "data": data})

    message = client.next_of("/image")
    assert (message["height"], message["data"]) == (1, data)


ROSLIBPY = """
import sys, threading
import roslibpy
ros = roslibpy.Ros(sys.argv[1])
ros.run(timeout=20)
assert "/scan" in ros.get_topics()
assert ros.get_service_type("/reset") == "flatland_msgs/Reset"
got, done = [], threading.Event()
scans = roslibpy.Topic(ros, "/scan", "sensor_msgs/LaserScan")
scans.subscribe(lambda message: (got.append(message), done.set()))
drive = roslibpy.Topic(ros, "/cmd_vel", "geometry_msgs/Twist")
drive.publish(roslibpy.Message({"linear": {"x": 1.0}}))
step = roslibpy.Service(ros, "/step", "flatland_msgs/Step")
assert step.call(roslibpy.ServiceRequest({"steps": 200}))["success"]
assert done.wait(20)
ros.set_param("/robot/speed", {"max": 1.5})
assert ros.get_param("/robot/speed/max") == 1.5
assert ros.get_params() == ["/robot/speed/max"]
ros.delete_param("/robot/speed")
assert ros.get_param("/robot/speed") is None
print(len(got[0]["ranges"]))
ros.terminate()
"""


@pytest.mark.slow
def test_roslibpy_lists_subscribes_publishes_and_calls(world):
    with running(world, is_paused=True) as server:
        url = server.clients.url("rosbridge", "ws")
        result = subprocess.run(
            [sys.executable, "-c", ROSLIBPY, url], capture_output=True, text=True, timeout=120
        )
    assert result.stdout.strip() == "401", result.stderr


def test_a_service_that_breaks_down_is_answered_in_each_protocol(server, client, monkeypatch):
    replace_service(monkeypatch, server, "/pause", lambda request: 1 / 0)
    expected = "/pause has failed: ZeroDivisionError('division by zero')"
    viewer = Viewer(server)

    response = client.call("/pause")
    call = struct.pack("<BIII", 2, viewer.services["/pause"]["id"], 7, 4) + b"json{}"
    viewer.socket.send(call)

    assert (response["result"], response["values"]) == (False, expected)
    assert viewer.receive_text("serviceCallFailure")["message"] == expected


def test_a_client_that_comes_in_a_pause_gets_the_time(client):
    client.call("/step", steps=3)

    assert client.subscribed("/clock").next_of("/clock")["clock"]["nsecs"] == 15_000_000


def test_nodes_are_found_by_what_they_offer(client):
    node = "/flatland_server"
    for service, arguments, expected in (
        ("nodes", {}, {"nodes": [node]}),
        ("service_providers", {"service": "flatland_msgs/Step"}, {"providers": [node]}),
        ("service_providers", {"service": "std_srvs/Nope"}, {"providers": []}),
        ("service_node", {"service": "/step"}, {"node": node}),
        ("service_node", {"service": "/nope"}, {"node": ""}),
        ("publishers", {"topic": "/scan"}, {"publishers": [node]}),
        ("publishers", {"topic": "/cmd_vel"}, {"publishers": []}),
        ("subscribers", {"topic": "/cmd_vel"}, {"subscribers": [node]}),
    ):
        assert client.call(f"/rosapi/{service}", **arguments)["values"] == expected
    details = client.call("/rosapi/node_details", node=node)["values"]
    assert "/scan" in details["publishing"]
    assert "/cmd_vel" in details["subscribing"]
    assert "/step" in details["services"]
    nothing = {"publishing": [], "subscribing": [], "services": []}
    assert client.call("/rosapi/node_details", node="/other")["values"] == nothing
