"""The server while its master fails, and its limit of open files; soak/ has more faults."""

import contextlib
import os
import signal
import subprocess
import sys
import xmlrpc.client
from pathlib import Path

import pytest
import tcpros_client
from flatland_msgs.srv import OpenWorld
from rosgraph_msgs.msg import Clock
from running_server import NODE, USUAL_FILES, WORLDS
from std_msgs.msg import UInt8
from waiting import wait_until

pytestmark = pytest.mark.slow


def wait_for_simulated_time(clock, seconds):
    """Waits until some time has passed in the simulation [s], on a connection to /clock."""
    begin = tcpros_client.next_message(clock, Clock).clock
    while (tcpros_client.next_message(clock, Clock).clock - begin).to_sec() < seconds:
        pass


def test_a_master_that_is_stopped_then_dies_does_not_stop_time(master, start_server):
    player = ("/clock", "rosgraph_msgs/Clock", "http://127.0.0.1:1")
    master.ask("registerPublisher", *player, caller="/rosbag_play")
    server = start_server()
    assert "/use_sim_time is not set" in server.log
    assert "/clock is also published by /rosbag_play: time will jump" in server.log
    clock = tcpros_client.subscribe(server.uri, "/clock", Clock)
    topics = master.topics()

    master.process.send_signal(signal.SIGSTOP)
    room = str(WORLDS / "test_room" / "world.yaml")
    assert server.call("/open_world", OpenWorld, path=room).success
    assert "~world_path is not set" in server.log
    spawning = [server.spawn("while_stopped")]
    wait_for_simulated_time(clock, 0.25)
    master.kill()
    spawning.append(server.spawn("while_dead"))
    wait_for_simulated_time(clock, 0.25)

    assert all(answer.success for answer in spawning)
    assert all("master" in answer.message for answer in spawning)
    assert "does not answer" in server.log

    # A new master knows nothing.
    master.start()
    wait_until(lambda: topics <= master.topics(), "the topics to be registered again")
    wait_until(lambda: "/while_dead/scan" in master.topics(), "those of the new robots")
    assert master.ask("lookupService", "/spawn_model")
    assert server.delete("while_dead").success
    wait_until(lambda: "/while_dead/scan" not in master.topics(), "those of the deleted one")


@contextlib.contextmanager
def stopped(master):
    """The master neither reads nor answers."""
    master.process.send_signal(signal.SIGSTOP)
    try:
        yield
    finally:
        master.process.send_signal(signal.SIGCONT)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_ends_the_server_while_the_master_is_stopped(master, start_server, number):
    server = start_server()
    with stopped(master):
        server.process.send_signal(number)
        assert server.process.wait(60) == 0
    assert "Traceback" not in server.log


def test_the_file_limit_is_raised_and_topics_open_no_files(start_server):
    server = start_server(max_files=256)
    limits = Path(f"/proc/{server.process.pid}/limits").read_text()
    [line] = [line for line in limits.splitlines() if line.startswith("Max open files")]
    assert int(line.split()[3]) > USUAL_FILES

    server.spawn("first")
    before = server.open_files()
    names = [f"r{number}" for number in range(40)]
    for name in names:
        assert server.spawn(name).success

    # Connections for service calls are closed a little later.
    wait_until(lambda: server.open_files() <= before + 2, "no more open files")
    for name in names:
        assert server.delete(name).success
    wait_until(lambda: server.open_files() <= before + 2, "no more open files")


def request_shutdown(server):
    """Requests the server's shutdown as rosnode kill does."""
    with contextlib.suppress(OSError):  # the server may end before it answers
        xmlrpc.client.ServerProxy(server.uri).shutdown("/test", "a test")


@pytest.mark.parametrize(
    "end",
    [lambda server: server.process.send_signal(signal.SIGINT), request_shutdown],
    ids=["signal", "rosnode kill"],
)
def test_the_master_knows_nothing_of_a_server_that_has_ended(master, start_server, end):
    server = start_server()
    for number in range(60):
        assert server.spawn(f"r{number}").success

    end(server)
    assert server.process.wait(60) == 0

    state = master.ask("getSystemState")
    left = [name for part in state for name, nodes in part if NODE in nodes]
    assert left == []


ASKING = """
import rospy
from flatland_server.ros import init_node
init_node("asking")
print("asks", flush=True)
while not rospy.is_shutdown():
    rospy.get_published_topics()
"""


def test_a_signal_ends_a_node_within_a_call_to_the_master(master):
    environment = {**os.environ, "ROS_MASTER_URI": master.uri}
    node = subprocess.Popen([sys.executable, "-c", ASKING], env=environment, stdout=subprocess.PIPE)
    try:
        assert node.stdout.readline() == b"asks\n"
        with stopped(master):
            node.send_signal(signal.SIGTERM)
            with pytest.raises(subprocess.TimeoutExpired):
                node.wait(0.1)
        assert node.wait(20) == 0
        assert "/asking" not in str(master.ask("getSystemState"))
    finally:
        node.kill()


STOPPING = """
import threading, time
import rospy
from std_msgs.msg import UInt8
from flatland_server.ros import init_node

def stop():
    ended.set()
    for topic in topics:
        topic.publish(1)
        topic.unregister()

init_node("stopping")
topics = [rospy.Publisher(f"/last_{number}", UInt8, queue_size=1) for number in range(30)]
ended = threading.Event()
rospy.on_shutdown(stop)
print("runs", flush=True)
while not all(topic.get_num_connections() for topic in topics):
    time.sleep(0.01)
print("is heard", flush=True)
ended.wait()
"""


def test_what_a_node_publishes_at_its_end_arrives(master):
    environment = {**os.environ, "ROS_MASTER_URI": master.uri}
    command = [sys.executable, "-c", STOPPING]
    node = subprocess.Popen(command, env=environment, stdout=subprocess.PIPE)
    try:
        assert node.stdout.readline() == b"runs\n"
        uri = master.ask("lookupNode", "/stopping")
        topics = [f"/last_{number}" for number in range(30)]
        with contextlib.ExitStack() as stack:
            connections = [tcpros_client.subscribe(uri, topic, UInt8) for topic in topics]
            for each in connections:
                stack.enter_context(each)
            assert node.stdout.readline() == b"is heard\n"
            node.send_signal(signal.SIGINT)
            for each in connections:
                assert tcpros_client.next_message(each, UInt8).data == 1
        assert node.wait(20) == 0
    finally:
        node.kill()
