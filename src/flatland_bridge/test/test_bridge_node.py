"""The node beside a ROS server: its topics and services for clients of rosbridge and Foxglove."""

import json
import os
import re
import struct
import subprocess
from types import SimpleNamespace

import pytest
from bridge_clients import Client
from ros_processes import executable
from running_server import ROBOT
from test_foxglove import Viewer
from test_greedy_clients import ask_until_closed, send_parts_of_messages
from waiting import wait_until
from websockets.exceptions import ConnectionClosed

from flatland_bridge.server import ROSBRIDGE

pytestmark = pytest.mark.slow


@pytest.fixture
def bridge(master, start_server, tmp_path):
    """The node beside a server, as what `Client` and `Viewer` connect to."""
    start_server()
    log = tmp_path / "bridge.log"
    with log.open("w") as file:
        process = subprocess.Popen(
            [executable("flatland_bridge", "bridge"), "_port:=0", "_foxglove_port:=0"],
            env={**os.environ, "ROS_MASTER_URI": master.uri, "PYTHONUNBUFFERED": "1"},
            stdout=file,
            stderr=subprocess.STDOUT,
        )
    try:
        wait_until(lambda: "Foxglove: " in log.read_text(), "the node to run")
        found = re.findall(r"(page|Foxglove): \w+(://\S+/)", log.read_text())
        addresses = {name.replace("page", ROSBRIDGE): f"ws{rest}" for name, rest in found}
        yield SimpleNamespace(
            clients=SimpleNamespace(url=lambda name, scheme: addresses[name]), log=log
        )
    finally:
        process.terminate()
        process.wait(20)


def test_clients_see_and_control_the_server(bridge):
    client = Client(bridge)
    topics = client.call("/rosapi/topics")["values"]["topics"]
    assert {"/clock", "/flatland_server/models", "/tf"} <= set(topics)
    assert client.call("/pause")["result"]
    spawned = client.call("/spawn_model", yaml_path=str(ROBOT), name="bot", ns="bot")
    assert spawned["values"]["success"], spawned
    wait_until(
        lambda: "/bot/scan" in client.call("/rosapi/topics")["values"]["topics"], "the topics"
    )
    client.subscribed("/flatland_server/models")
    while "bot" not in [
        each["name"] for each in client.next_of("/flatland_server/models")["models"]
    ]:
        pass
    client.subscribed("/bot/scan", compression="cbor").subscribed("/bot/odometry/ground_truth")
    client.send("advertise", topic="/bot/cmd_vel", type="geometry_msgs/Twist")

    def has_moved():
        client.send("publish", topic="/bot/cmd_vel", msg={"linear": {"x": 0.5}})
        assert client.call("/step", steps=20)["values"]["success"]
        # The node's own subscribers connect in the background: the first steps may be without.
        topics = {each.get("topic"): each.get("msg") for each in client.kept}
        if not {"/bot/scan", "/bot/odometry/ground_truth"} <= topics.keys():
            return False
        return topics["/bot/odometry/ground_truth"]["pose"]["pose"]["position"]["x"] > 0.05

    wait_until(has_moved, "the robot to drive")
    assert len(client.next_of("/bot/scan")["ranges"].value) == 4 * 1081
    late = Client(bridge)
    late.subscribed("/flatland_server/debug/walls")
    assert late.next_of("/flatland_server/debug/walls")["layers"]  # latched, for the second, too
    other = Client(bridge)
    other.subscribed("/flatland_server/debug/walls")
    assert other.next_of("/flatland_server/debug/walls")["layers"]
    assert "no service" in client.call("/nope")["values"]


def test_viewers_of_foxglove_do_too(bridge):
    viewer = Viewer(bridge)
    viewer.subscribe("/clock", 3)
    viewer.call("/resume", "json", b"{}")
    assert struct.unpack_from("<I", viewer.receive_binary(1)) == (3,)
    answer = json.loads(viewer.call("/delete_model", "json", b'{"name": "robto"}'))
    assert not answer["success"]


@pytest.mark.parametrize(
    ("parameter", "expected"),
    [("_token:=''", "token: expected one character"), ("_client_memory:=0", "expected 1 MB")],
)
def test_a_wrong_parameter_is_refused(master, parameter, expected):
    name = f"__name:=bridge{len(expected)}"  # parameters stay
    command = [executable("flatland_bridge", "bridge"), "_port:=0", name, parameter]
    environment = {**os.environ, "ROS_MASTER_URI": master.uri}
    result = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=60)

    assert result.returncode == 1
    assert expected in result.stdout + result.stderr


def test_a_client_that_takes_too_much_is_told_and_disconnected(bridge):
    greedy = Client(bridge)
    with pytest.raises(ConnectionClosed) as closed:
        ask_until_closed(greedy, lambda number: send_parts_of_messages(greedy, number), 200)

    assert closed.value.rcvd.code == 1008
    assert Client(bridge).call("/rosapi/nodes")["result"]
