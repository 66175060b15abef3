"""The node beside a ROS server: its topics and services for clients of rosbridge and Foxglove."""

import json
import os
import re
import signal
import socket
import struct
import subprocess
import threading
from types import SimpleNamespace

import pytest
import tcpros_client
from bridge_clients import Client
from ros_processes import executable
from rosgraph.network import encode_ros_handshake_header
from running_server import ROBOT
from test_foxglove import Viewer
from test_greedy_clients import ask_until_closed, send_parts_of_messages
from test_parameters import asked, check_limit, check_parameters, value_of
from waiting import wait_until
from websockets.exceptions import ConnectionClosed

from flatland_bridge.server import ROSBRIDGE

pytestmark = pytest.mark.slow


@pytest.fixture
def master(master):
    """A master with simulated time, as under roslaunch."""
    master.ask("setParam", "/use_sim_time", True)
    return master


@pytest.fixture
def start_bridge(master, tmp_path):
    """Starts the node, and returns it as what `Client` and `Viewer` connect to."""
    log = tmp_path / "bridge.log"
    processes = []

    def start():
        with log.open("w") as file:
            process = subprocess.Popen(
                [executable("flatland_bridge", "bridge"), "_port:=0", "_foxglove_port:=0"],
                env={**os.environ, "ROS_MASTER_URI": master.uri, "PYTHONUNBUFFERED": "1"},
                stdout=file,
                stderr=subprocess.STDOUT,
            )
        processes.append(process)
        wait_until(lambda: "Foxglove: " in log.read_text(), "the node to run")
        found = re.findall(r"(page|Foxglove): \w+(://\S+/)", log.read_text())
        addresses = {name.replace("page", ROSBRIDGE): f"ws{rest}" for name, rest in found}
        return SimpleNamespace(
            clients=SimpleNamespace(url=lambda name, scheme: addresses[name]), log=log
        )

    yield start
    for process in processes:
        process.terminate()
    for process in processes:
        process.wait(20)


@pytest.fixture
def bridge(start_server, start_bridge):
    """The node beside a server."""
    start_server()
    return start_bridge()


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


def test_clients_get_clock_although_the_node_subscribes_to_it(bridge):
    client, other = Client(bridge), Client(bridge)
    client.subscribed("/clock")
    other.subscribed("/clock", compression="cbor")
    for each in (client, other):
        first, second = (each.next_of("/clock")["clock"] for _ in range(2))
        assert first != second

    def time():
        return client.call("/rosapi/get_time")["values"]["time"]

    before = time()
    wait_until(lambda: time() != before, "the node's own time to go on")
    assert "Traceback" not in bridge.log.read_text()


def test_services_come_and_go_with_their_servers(master, start_server, start_bridge):
    former = start_server()
    former.kill()  # its services stay registered
    bridge = start_bridge()
    client = Client(bridge)
    assert "/pause" not in client.call("/rosapi/services")["values"]["services"]

    def answers():
        return client.call("/pause")["result"]

    server = start_server()
    wait_until(answers, "the services of a new server")
    server.kill()
    last = start_server()
    wait_until(answers, "the services of the next one")
    viewer = Viewer(bridge)
    last.process.terminate()
    assert (
        viewer.services["/pause"]["id"] in viewer.receive_text("unadvertiseServices")["serviceIds"]
    )


def test_an_advertised_topic_ends_with_its_last_client(bridge):
    clients, other = [Client(bridge) for _ in range(2)], Client(bridge)

    def is_there():
        return "/new" in other.call("/rosapi/topics")["values"]["topics"]

    for client in clients:
        client.send("advertise", topic="/new", type="std_msgs/Bool")
        client.call("/rosapi/topics")
    wait_until(is_there, "the topic")
    clients[0].send("unadvertise", topic="/new")
    clients[0].call("/rosapi/topics")
    assert is_there()
    clients[1].socket.close()
    wait_until(lambda: not is_there(), "the topic to end")


def test_an_implicit_publisher_ends_with_its_client(master, bridge):
    master.ask("registerSubscriber", "/note", "std_msgs/String", "http://127.0.0.1:9/")
    client = Client(bridge)
    wait_until(lambda: "/note" in types_of(client), "the topic")

    def publishers():
        return [nodes for topic, nodes in master.ask("getSystemState")[0] if topic == "/note"]

    client.send("publish", topic="/note", msg={"data": "hello"})
    wait_until(lambda: publishers() == [["/bridge"]], "the publisher")
    client.send("publish", topic="/note", msg={"data": "again"})
    client.call("/rosapi/nodes")
    client.socket.close()
    wait_until(lambda: publishers() == [], "the publisher to end")


def types_of(client):
    """The types of topics that a client sees, by name."""
    found = client.call("/rosapi/topics")["values"]
    return dict(zip(found["topics"], found["types"]))


def test_nodes_are_those_of_the_master(bridge):
    client = Client(bridge)
    for service, arguments, expected in (
        ("service_providers", {"service": "flatland_msgs/Step"}, ["/flatland_server"]),
        ("service_node", {"service": "/step"}, "/flatland_server"),
        ("service_node", {"service": "/bridge/get_loggers"}, "/bridge"),
        ("subscribers", {"topic": "/clock"}, ["/bridge"]),
        ("publishers", {"topic": "/clock"}, ["/flatland_server"]),
    ):
        values = client.call(f"/rosapi/{service}", **arguments)["values"]
        assert list(values.values()) == [expected], service
    assert {"/flatland_server", "/bridge"} <= set(client.call("/rosapi/nodes")["values"]["nodes"])


def test_parameters_are_those_of_the_master(master, bridge):
    client = Client(bridge)
    check_parameters(client, "/bridge")
    check_limit(client)
    asked(client, "set_param", name="/x", value='{"y": 7}')

    assert master.ask("getParam", "/x/y") == 7
    master.ask("setParam", "/x/y", 8)
    assert value_of(client, "/x/y") == 8


class SilentService:
    """A service with a server that answers the headers of connections, and then nothing."""

    def __init__(self, master, name):
        self.begun, self.ended = [], []  # calls, by the addresses of their connections
        self._listening = socket.create_server(("127.0.0.1", 0))
        uri = f"rosrpc://127.0.0.1:{self._listening.getsockname()[1]}"
        master.ask("registerService", name, uri, "http://127.0.0.1:9/", caller="/silent")
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self):
        while True:
            connection = self._listening.accept()
            threading.Thread(target=self._serve, args=connection, daemon=True).start()

    def _serve(self, connection, address):
        header = tcpros_client.read_header(connection)
        fields = {"callerid": "/silent", "type": "std_srvs/Empty", "md5sum": header["md5sum"]}
        connection.sendall(encode_ros_handshake_header(fields))
        if "probe" in header:
            connection.close()
            return
        self.begun.append(address)
        while connection.recv(1000):
            pass
        self.ended.append(address)


def test_calls_that_are_never_answered_end_with_their_client(master, start_bridge):
    service = SilentService(master, "/silent")
    bridge = start_bridge()
    client, other = Client(bridge), Client(bridge)
    wait_until(lambda: "/silent" in client.call("/rosapi/services")["values"]["services"], "it")
    for count, each in ((4, client), (8, other)):
        for _ in range(4):
            each.send("call_service", service="/silent")
        wait_until(lambda count=count: len(service.begun) == count, "the calls")

    client.socket.close()

    wait_until(
        lambda: {*service.begun[:4]} <= {*service.ended}, "the calls of the client that left"
    )
    assert not {*service.begun[4:]} & {*service.ended}
    other.socket.close()
    wait_until(lambda: len(service.ended) == 8, "the calls of the other")


def test_a_server_that_is_stopped_does_not_delay_the_node(start_server, start_bridge):
    server = start_server()
    server.process.send_signal(signal.SIGSTOP)
    try:
        client = Client(start_bridge())
        assert "/clock" in client.call("/rosapi/topics")["values"]["topics"]
        assert "/pause" not in client.call("/rosapi/services")["values"]["services"]
    finally:
        server.process.send_signal(signal.SIGCONT)
    wait_until(lambda: client.call("/pause")["result"], "its services")


def test_calls_to_a_stopped_server_fail_and_delay_no_others(start_server, start_bridge):
    server = start_server()
    bridge = start_bridge()
    client, other = Client(bridge), Client(bridge)
    server.process.send_signal(signal.SIGSTOP)
    try:
        for number in range(10):
            client.send("call_service", id=number, service="/pause")
        answer = client.receive_until(lambda each: each["op"] == "service_response")
        assert answer["values"] == "the service /pause cannot be called: it does not answer"
        assert other.call("/rosapi/topics")["result"]
    finally:
        server.process.send_signal(signal.SIGCONT)


def test_a_master_that_is_stopped_stops_no_client(master, bridge):
    client = Client(bridge)
    client.subscribed("/clock")
    client.next_of("/clock")
    master.process.send_signal(signal.SIGSTOP)
    try:
        client.send("subscribe", topic="/flatland_server/state")
        client.send("advertise", topic="/new", type="std_msgs/Bool")
        assert client.call("/rosapi/topics")["result"]
        assert client.call("/toggle_pause")["result"]
        assert client.call("/toggle_pause")["result"]
        refused = client.call("/rosapi/set_param", name="/x", value="1")
        assert refused["values"] == "the ROS master does not answer"
        client.kept.clear()
        assert client.next_of("/clock")
    finally:
        master.process.send_signal(signal.SIGCONT)
    assert client.next_of("/flatland_server/state")


@pytest.mark.parametrize(
    ("parameter", "expected"),
    [
        ("_token:=''", "token: expected one character"),
        ("_client_memory:=0", "expected a number above 0"),
    ],
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
