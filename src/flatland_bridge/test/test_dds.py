"""ROS 2 over DDS: `flatland serve --ros2`."""

import json
import signal
import socket
import subprocess
import sys

import pytest
from bridge_clients import running
from waiting import wait_until

from flatland_bridge.websocket_server import Access
from flatland_server.exceptions import FlatlandError
from flatland_server.messages.message_types import get
from flatland_server.messages.service_types import get as get_service

pytest.importorskip("cyclonedds", reason="cyclonedds and rosbags need Python 3.10")

from cyclonedds.domain import Domain
from cyclonedds.qos import Policy
from dds_peer import (
    BEST_EFFORT,
    LATCHED,
    Header,
    LaserScan,
    ModelList,
    Participant,
    Peer,
    String,
    Time,
    Transforms,
    Twist,
    TwistStamped,
    Vector3,
    free_domain,
    next_of,
)

from flatland2d.ros2_messages import Ros2Messages
from flatland_bridge.dds_server import configuration, udp_sockets

pytestmark = pytest.mark.slow


@pytest.fixture(autouse=True)
def domain(monkeypatch):
    """The domain of a test."""
    number = free_domain()
    monkeypatch.setenv("ROS_DOMAIN_ID", str(number))
    return number


@pytest.fixture
def server(world, domain):
    """A server with a paused simulation."""
    with running(world, is_paused=True, ros2="jazzy") as each:
        yield each


@pytest.fixture
def peer(server):
    """A node of ROS 2."""
    return Peer(server.dds.domain)


def step(server, count):
    assert server.graph.call(
        "/step", get_service("flatland_msgs/Step").request(steps=count)
    ).success


def when_subscribed(server, topic, is_subscribed=True):
    wait_until(lambda: server.graph.wants(topic) == is_subscribed, topic)


def test_a_node_receives_scans(server, peer):
    assert not server.graph.wants("/scan")
    reader = peer.reader("rt/scan", LaserScan, BEST_EFFORT)
    when_subscribed(server, "/scan")

    step(server, 100)

    scans = [next_of(reader) for _ in range(10)]
    stamps = [scan.header_.stamp_.nanosec_ for scan in scans]
    assert stamps == [50_000_000 * number for number in range(10)]
    expected = server.transport.last("/scan")
    assert scans[-1].ranges_ == pytest.approx(expected.ranges)
    assert scans[-1].header_.frame_id_ == expected.header.frame_id
    del reader
    when_subscribed(server, "/scan", False)


@pytest.mark.parametrize("is_stamped", [False, True])
def test_a_node_drives(server, peer, is_stamped):
    twist = Twist(Vector3(0.5, 0.0, 0.0), Vector3(0.0, 0.0, 0.0))
    kind, command = Twist, twist
    if is_stamped:
        kind, command = TwistStamped, TwistStamped(Header(Time(0, 0), ""), twist)
    arrivals = []
    server.transport.subscribe("/cmd_vel", get("geometry_msgs/Twist"), arrivals.append)

    peer.writer("rt/cmd_vel", kind).write(command)
    wait_until(lambda: arrivals, "the command")
    step(server, 200)

    assert server.manager.world.models["robot"].pose.x == pytest.approx(0.5, abs=0.02)


def test_endpoints_have_the_names_types_hashes_and_quality_of_ros_2(server, peer):
    topics, types = server.graph.topics, Ros2Messages("jazzy")
    for is_writer, expected in ((True, topics.published), (False, topics.subscribed)):
        found = peer.endpoints(is_writer, {f"rt{topic}" for topic in expected})
        for topic, kind in expected.items():
            endpoint, package, name = found[f"rt{topic}"], *kind.split("/")
            if not is_writer and topic == "/cmd_vel":
                assert "geometry_msgs::msg::dds_::Twist" in endpoint.type_name
                continue
            assert endpoint.type_name == f"{package}::msg::dds_::{name}_"
            user_data = endpoint.qos[Policy.Userdata].data.decode()
            assert user_data == f"typehash={types.type_of(get(kind)).type_hash};"
            is_reliable = endpoint.qos[Policy.Reliability] != Policy.Reliability.BestEffort
            assert is_reliable == (topic != "/scan")
            is_latched = endpoint.qos[Policy.Durability] == Policy.Durability.TransientLocal
            assert is_latched == (topic in topics.latched)
    assert "/tf_static" in topics.latched


def test_a_node_is_announced(server, peer):
    reader = peer.reader("ros_discovery_info", Participant, LATCHED)

    wait_until(lambda: server.dds._outputs, "the topics")
    participant = next_of(reader)

    [node] = participant.node_entities_info_seq_
    assert (node.node_namespace_, node.node_name_) == ("/", "flatland_server")
    writers = {bytes(each.data_) for each in node.writer_gid_seq_}
    assert {each.writer.guid.bytes for each in server.dds._outputs.values()} == writers
    assert len(node.reader_gid_seq_) == len(server.dds._inputs)


def test_a_late_subscriber_gets_the_last_latched_message(server, peer):
    first = peer.matched_reader("rt/tf_static", Transforms, LATCHED)
    frames = [each.child_frame_id_ for each in next_of(first).transforms_]
    second = peer.matched_reader("rt/tf_static", Transforms, LATCHED)

    assert [each.child_frame_id_ for each in next_of(second).transforms_] == frames
    assert "odom" in frames


def test_a_subscriber_gets_the_present_message_after_others_have_gone(server, peer):
    topic = "/flatland_server/models"
    first = peer.reader(f"rt{topic}", ModelList, LATCHED)
    assert [each.name_ for each in next_of(first).models_] == ["robot"]
    del first
    when_subscribed(server, topic, False)

    kind = get_service("flatland_msgs/SpawnModel")
    server.graph.call("/spawn_model", kind.request(yaml_path="robot.model.yaml", name="other"))
    second = peer.reader(f"rt{topic}", ModelList, LATCHED)

    def names():
        return [each.name_ for each in next_of(second).models_]

    # The former writer may exist for a moment longer, with the message before.
    wait_until(lambda: names() == ["robot", "other"], "the present message")


def test_a_run_is_the_same_with_nodes(world, domain):
    command = get("geometry_msgs/Twist")()
    command.linear.x, command.angular.z = 0.5, 0.3

    def poses(ros2):
        with running(world, is_paused=True, ros2=ros2) as server:
            server.graph.publish("/cmd_vel", command)
            if ros2 is not None:
                peer = Peer(domain)
                reader = peer.reader("rt/scan", LaserScan, BEST_EFFORT)
                transforms = peer.reader("rt/tf", Transforms)  # neither of them reads
                when_subscribed(server, "/scan")
                when_subscribed(server, "/tf")
                assert reader != transforms
            result = []
            for _ in range(20):
                step(server, 20)
                result.append(server.manager.world.models["robot"].pose)
            return result

    assert poses("jazzy") == poses(None)


def test_services_are_topics(server, peer):
    responses = peer.matched_reader("rt/flatland_server/service_response", String)
    wait_until(lambda: server.dds._graph._receivers, "the subscription")
    calls = peer.writer("rt/flatland_server/call_service", String)

    def response_to(call):
        calls.write(String(call if isinstance(call, str) else json.dumps(call)))
        return json.loads(next_of(responses).data_)

    answer = response_to({"service": "/step", "args": {"steps": 20}, "id": 7})
    assert answer["values"]["time"] == {"secs": 0, "nsecs": 100_000_000}
    assert (answer["id"], answer["result"]) == (7, True)
    assert response_to({"service": "/stop"})["values"].startswith('there is no service "/stop"')
    assert response_to("nothing")["values"].startswith("expected JSON")
    assert not response_to({"service": "/step", "args": {"steps": "x"}})["result"]


def test_a_subscriber_that_asks_for_more_is_named(server, peer, caplog):
    reader = peer.reader("rt/scan", LaserScan)  # reliable
    wait_until(lambda: caplog.messages, "a warning")

    assert reader.get_subscription_matched_status().current_count == 0
    assert caplog.messages[0].startswith("a subscriber to /scan gets no messages: it asks for")
    assert "(best effort, volatile)" in caplog.messages[0]


def test_only_this_machine_is_heard(server):
    devices = {
        each.getsockname(): each.getsockopt(socket.SOL_SOCKET, socket.SO_BINDTODEVICE, 16)
        for each in udp_sockets()
    }

    assert devices
    for (host, _), device in devices.items():
        assert host == "127.0.0.1" or device == b"lo\0"


@pytest.mark.parametrize(
    ("variable", "options", "text"),
    [
        ("233", {}, "ROS_DOMAIN_ID: expected 0 to 232"),
        ("x", {}, "ROS_DOMAIN_ID: expected 0 to 232"),
        ("", {"ros2": "jazy"}, "expected a ROS 2 of .*jazzy"),
        ("", {"access": Access(token="abc")}, "DDS has no token"),
        ("", {"access": Access("203.0.113.1")}, "cannot"),
    ],
)
def test_what_cannot_be_served_is_named(world, monkeypatch, variable, options, text):
    monkeypatch.setenv("ROS_DOMAIN_ID", variable)
    with pytest.raises(FlatlandError, match=text), running(world, **{"ros2": "jazzy", **options}):
        pass


def test_another_process_is_found(world, domain):
    command = [sys.executable, "-m", "flatland2d", "serve", str(world), "--ros2", "humble"]
    process = subprocess.Popen(
        [*command, "--port", "0", "--foxglove-port", "0"], stdout=subprocess.PIPE, text=True
    )
    try:
        lines = [process.stdout.readline() for _ in range(4)]
        assert lines[3] == f"ROS 2: domain {domain}, humble\n"
        own = Domain(domain, configuration(domain, None))
        assert own
        reader = Peer(domain).reader("rt/scan", LaserScan, BEST_EFFORT)
        stamps = [next_of(reader).header_.stamp_ for _ in range(5)]
    finally:
        process.send_signal(signal.SIGINT)
        assert process.wait(20) == 0
    times = [20 * stamp.sec_ + stamp.nanosec_ // 50_000_000 for stamp in stamps]
    assert times == list(range(times[0], times[0] + 5))
