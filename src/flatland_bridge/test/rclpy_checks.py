"""Nodes of ROS 2 beside `flatland serve --ros2`: plain rclpy, in a process of its own.

`test_ros2.py` runs this file in an environment with ROS 2.
"""

import math
import select
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import rclpy
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseWithCovarianceStamped, Twist, TwistStamped
from nav_msgs.msg import OccupancyGrid, Odometry
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.msg import ParameterValue
from rcl_interfaces.srv import GetParameters, ListParameters, SetParameters
from rclpy.action import ActionClient
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import LaserScan
from std_srvs.srv import Empty, Trigger

from flatland2d.ros2_messages import Ros2Messages
from flatland_bridge.ros2.node import distribution
from flatland_server.messages.message_types import get

LIMIT = 60.0
"""Real time after which a test fails [s]."""
ROBOT = """
bodies:
  - {name: base, footprints: [{type: circle, radius: 0.3, density: 1}]}
plugins:
  - {type: DiffDrive, name: drive, body: base, pub_rate: 20}
  - type: Laser
    name: laser
    body: base
    range: 20
    update_rate: 10
    angle: {min: -2.0, max: 2.0, increment: 0.0037}
"""
CAR = """
bodies:
  - {name: base, footprints: [{type: circle, radius: 0.3, density: 1}]}
plugins:
  - {type: AckermannDrive, name: drive, body: base, wheelbase: 0.3, max_steer_angle: 0.4}
"""
STALLED = """
import sys, rclpy
from sensor_msgs.msg import LaserScan
rclpy.init()
node = rclpy.create_node("stalled")
for topic in sys.argv[1:]:
    node.create_subscription(LaserScan, topic, lambda scan: print(scan.header, flush=True), 10)
rclpy.spin(node)
"""
SHORT_LEASE = """
<dds xmlns="http://www.eprosima.com"><profiles>
  <participant profile_name="short_lease" is_default_profile="true">
    <rtps><builtin><discovery_config>
      <leaseDuration><sec>2</sec></leaseDuration>
      <leaseAnnouncement><sec>0</sec><nanosec>500000000</nanosec></leaseAnnouncement>
    </discovery_config></builtin></rtps>
  </participant>
</profiles></dds>
"""
PATIENT = QoSProfile(depth=100)
"""For a reader that must lose nothing while this process does something else for seconds."""
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
COMMANDS = {"jazzy": Twist}.get(distribution(), TwistStamped)


class Peer:
    """A node of this process."""

    def __init__(self, **options):
        self.node = rclpy.create_node("peer", **options)

    def wait_until(self, is_true, what):
        """Waits until a condition is true, and returns its value."""
        ends = time.monotonic() + LIMIT
        while time.monotonic() < ends:
            result = is_true()
            if result:
                return result
            rclpy.spin_once(self.node, timeout_sec=0.1)
        raise AssertionError(f"{what} did not come")

    def received(self, kind, topic, qos=10):
        """A list that gets the messages of a topic."""
        messages = []
        self.node.create_subscription(kind, topic, messages.append, qos)
        return messages

    def first(self, kind, topic, qos=10):
        messages = self.received(kind, topic, qos)
        return self.wait_until(lambda: messages, topic)[0]

    def call(self, kind, name, /, **fields):
        client = self.node.create_client(kind, name)
        self.wait_until(client.service_is_ready, name)
        future = client.call_async(kind.Request(**fields))
        self.wait_until(future.done, name)
        self.node.destroy_client(client)
        return future.result()

    def put(self, name, value):
        """Sets a parameter of the server."""
        parameter = Parameter(name, value=value).to_parameter_msg()
        service = "/flatland_server/set_parameters"
        return self.call(SetParameters, service, parameters=[parameter]).results[0]

    def commands(self, topic):
        """A publisher of commands that has a subscriber."""
        publisher = self.node.create_publisher(COMMANDS, topic, 10)
        self.wait_until(publisher.get_subscription_count, topic)

        def send(speed):
            command = COMMANDS()
            (command.twist if COMMANDS is TwistStamped else command).linear.x = speed
            publisher.publish(command)

        return send

    def names(self):
        return [name for name, _ in self.node.get_node_names_and_namespaces()]


@pytest.fixture
def peer():
    rclpy.init()
    each = Peer()
    yield each
    each.node.destroy_node()
    rclpy.shutdown()


@pytest.fixture(scope="module")
def world(tmp_path_factory):
    """A world with ten robots in a hall."""
    folder = tmp_path_factory.mktemp("world")
    (folder / "robot.model.yaml").write_text(ROBOT)
    models = "".join(
        f"  - {{name: r{n}, namespace: r{n}, model: robot.model.yaml, pose: [{n}, 0, 1.57]}}\n"
        for n in range(1, 10)
    )
    (folder / "world.yaml").write_text(
        "properties: {}\n"
        "layers:\n"
        "  - {name: hall, map: {segments: [[-5, 5, 15, 5], [15, -5, 15, 5]]}}\n"
        "models:\n"
        f"  - {{name: robot, model: robot.model.yaml}}\n{models}"
    )
    return folder / "world.yaml"


@pytest.fixture(scope="module")
def starts(world):
    """Starts the node as `ros2 launch` does; returns its process."""
    processes = []

    def start(*arguments, **parameters):
        log = world.with_name(f"log{len(processes)}")
        given = {"world_path": world, "show_viz": False, **parameters}
        values = [word for pair in given.items() for word in ("-p", "{}:={}".format(*pair))]
        code = "import sys; from flatland_bridge.ros2.server_node import main; sys.exit(main())"
        with log.open("w") as file:
            process = subprocess.Popen(
                [sys.executable, "-c", code, "--ros-args", *values, *arguments],
                stdout=file,
                stderr=subprocess.STDOUT,
            )
        process.log = log
        processes.append(process)
        return process

    yield start, processes
    end(processes)


def end(processes):
    while processes:
        process = processes.pop()
        process.kill()
        process.wait()
        print(process.log.read_text())


@pytest.fixture(scope="module")
def server(starts):
    """One server for several tests."""
    of_launch_file = {"control_period": "''", "no_return": "inf"}
    given = {"map": True, "odom_topic": "odom", "initial_pose": "robot", "seed": 7}
    return starts[0](**{"show_viz": True, **of_launch_file, **given})


@pytest.fixture
def start(starts):
    """Starts the node for one test, after the server of others has ended."""
    end(starts[1])
    return starts[0]


def test_types_have_the_hashes_of_the_standard(server, peer):
    types = Ros2Messages()
    node = peer.node
    expected = {"/scan", "/odom", "/clock", "/tf", "/tf_static"}
    expected |= {"/flatland_server/models", "/flatland_server/debug/models"}

    def publishers():
        found = {topic: node.get_publishers_info_by_topic(topic) for topic in expected}
        return found if all(found.values()) else None

    for topic, (info, *_) in peer.wait_until(publishers, "the topics").items():
        kind = types.type_of(get(info.topic_type.replace("/msg/", "/")))
        assert str(info.topic_type_hash) == kind.type_hash, topic


def test_transforms(server, peer):
    import tf2_msgs.msg as tf2_msgs

    static = peer.first(tf2_msgs.TFMessage, "/tf_static", LATCHED)
    moving = peer.first(tf2_msgs.TFMessage, "/tf", 100)

    frames = {(each.header.frame_id, each.child_frame_id) for each in static.transforms}
    assert ("base", "laser") in frames  # a mount
    assert ("odom", "base") in {
        (each.header.frame_id, each.child_frame_id) for each in moving.transforms
    }
    assert not any(parent == "map" for parent, _ in frames)  # a localiser's


def test_a_robot_is_driven_and_told_where_it_is(server, peer):
    send = peer.commands("/cmd_vel")
    poses = peer.received(Odometry, "/odom")
    peer.wait_until(
        lambda: send(0.5) or (poses and poses[-1].pose.pose.position.x > 0.3), "a metre"
    )
    send(0.0)

    truth = peer.received(Odometry, "/odometry/ground_truth")
    publisher = peer.node.create_publisher(PoseWithCovarianceStamped, "/initialpose", 10)
    peer.wait_until(publisher.get_subscription_count, "/initialpose")
    pose = PoseWithCovarianceStamped()
    pose.header.frame_id = "map"
    pose.pose.pose.position.y = -3.0
    pose.pose.pose.orientation.w = 1.0
    publisher.publish(pose)
    peer.wait_until(lambda: truth and truth[-1].pose.pose.position.y < -2.9, "the new place")


def test_services_and_their_errors(server, peer):
    import flatland_msgs.srv as srv

    offered = dict(
        peer.wait_until(
            lambda: (
                [each for each in peer.node.get_service_names_and_types() if each[0] == "/step"]
                and peer.node.get_service_names_and_types()
            ),
            "the services",
        )
    )
    assert {"/spawn_model", "/delete_model", "/move_model", "/reset", "/seek"} <= set(offered)

    model = {"yaml_path": "robot.model.yaml", "name": "new", "ns": "new"}
    assert peer.call(srv.SpawnModel, "/spawn_model", **model).success
    peer.first(LaserScan, "/new/scan")
    again = peer.call(srv.SpawnModel, "/spawn_model", **model)
    assert (again.success, "new" in again.message) == (False, True)
    missing = peer.call(srv.SpawnModel, "/spawn_model", yaml_path="/nothing.yaml", name="x")
    assert not missing.success
    peer.call(Empty, "/pause")
    stepped = peer.call(srv.Step, "/step", steps=20)
    assert stepped.success
    assert not peer.call(srv.Step, "/step", steps=0).success
    waiting = peer.node.create_client(srv.Step, "/step")
    peer.wait_until(waiting.service_is_ready, "/step")
    step = waiting.call_async(srv.Step.Request(steps=1, expect=["/cmd_vel"]))
    peer.call(Empty, "/pause")  # ends the wait
    peer.wait_until(step.done, "the end of the wait")
    assert not step.result().success
    assert peer.call(srv.DeleteModel, "/delete_model", name="new").success
    assert peer.call(Trigger, "/undo").success
    assert "expected" in peer.call(srv.ChangeRate, "/change_rate", rate=math.nan).message
    peer.call(Empty, "/resume")


def test_calls_that_come_at_once_are_all_answered(server, peer):
    client = peer.node.create_client(Empty, "/pause", qos_profile=PATIENT)
    peer.wait_until(client.service_is_ready, "/pause")
    calls = [client.call_async(Empty.Request()) for _ in range(60)]
    peer.wait_until(lambda: all(call.done() for call in calls), "the answers")
    peer.node.destroy_client(client)
    peer.call(Empty, "/resume")


def test_the_action_makes_steps(server, peer):
    from simulation_interfaces.action import SimulateSteps
    from simulation_interfaces.msg import Result, SimulatorFeatures
    from simulation_interfaces.srv import GetSimulatorFeatures

    features = peer.call(GetSimulatorFeatures, "/get_simulator_features").features.features
    assert SimulatorFeatures.STEP_SIMULATION_ACTION in features
    client = ActionClient(peer.node, SimulateSteps, "/simulate_steps")
    peer.wait_until(client.server_is_ready, "the action")
    feedback, clocks = [], peer.received(Clock, "/clock")

    def time_of_the_pause():
        clocks.clear()
        peer.wait_until(lambda: len(clocks) > 1 and clocks[-1] == clocks[-2], "the same time twice")
        return clocks[-1].clock.sec * 10**9 + clocks[-1].clock.nanosec

    def send(steps):
        goal = SimulateSteps.Goal(steps=steps)
        future = client.send_goal_async(goal, lambda each: feedback.append(each.feedback))
        return peer.wait_until(lambda: future.done() and future.result(), "an answer")

    def end(goal):
        future = goal.get_result_async()
        answer = peer.wait_until(lambda: future.done() and future.result(), "a result")
        return answer.status, answer.result.result

    status, result = end(send(3))  # while time goes on
    assert (status, result.result) == (GoalStatus.STATUS_ABORTED, Result.RESULT_OPERATION_FAILED)
    assert "not paused" in result.error_message
    peer.call(Empty, "/pause")
    before = time_of_the_pause()
    status, result = end(send(8))
    assert (status, result.result) == (GoalStatus.STATUS_SUCCEEDED, Result.RESULT_OK)
    assert time_of_the_pause() == before + 8 * 5_000_000

    feedback.clear()
    goal = send(2**63)
    peer.wait_until(lambda: len(feedback) > 8, "some steps")
    done = [each.completed_steps for each in feedback]
    assert done == sorted(set(done))  # rclpy's client may lose some, and all after the result
    assert {each.completed_steps + each.remaining_steps for each in feedback} == {2**63}
    assert end(send(1))[0] == GoalStatus.STATUS_SUCCEEDED  # not held up by a goal without an end
    status, result = end(goal)
    assert status == GoalStatus.STATUS_ABORTED
    assert "replaced by another goal after" in result.error_message

    goal = send(2**63)
    cancelling = goal.cancel_goal_async()
    peer.wait_until(cancelling.done, "the end")
    status, result = end(goal)
    assert status == GoalStatus.STATUS_CANCELED
    assert "cancelled after" in result.error_message
    assert end(send(0))[0] == GoalStatus.STATUS_SUCCEEDED
    peer.call(Empty, "/resume")
    client.destroy()


def test_services_of_types_with_other_fields_are_left_out(server, peer):
    def services():
        names = [name for name, _ in peer.node.get_service_names_and_types()]
        return "/step_simulation" in names and names

    assert "/load_world" not in peer.wait_until(services, "the services")
    text = "ROS 2 has no package simulation_interfaces, or another version"
    peer.wait_until(lambda: text in server.log.read_text(), "a line that says so")


def test_missing_types_of_spawned_models_are_told_once(server, world, peer):
    import flatland_msgs.srv as srv

    world.with_name("car.model.yaml").write_text(CAR)
    for name in ("car1", "car2"):
        car = {"yaml_path": "car.model.yaml", "name": name, "ns": name}
        assert peer.call(srv.SpawnModel, "/spawn_model", **car).success
        peer.commands(f"/{name}/cmd_vel")
        peer.call(ListParameters, "/flatland_server/list_parameters")  # comes after the line
        log = server.log.read_text()
        assert log.count("ackermann_msgs") == 1
        assert "so 2 names are left out, such as /car1/ackermann" in log


def test_parameters_are_read_and_set(server, peer):
    names = peer.call(ListParameters, "/flatland_server/list_parameters").result.names
    assert {"world_path", "seed", "update_rate", "map"} <= set(names)
    [seed] = peer.call(GetParameters, "/flatland_server/get_parameters", names=["seed"]).values
    assert seed.integer_value == 7

    assert peer.put("update_rate", 400.0).successful
    assert "above 0" in peer.put("update_rate", -1.0).reason
    assert not peer.put("seed", 8).successful


def test_a_parameter_of_unknown_type_does_not_make_it_deaf(server, peer):
    client = peer.node.create_client(SetParameters, "/flatland_server/set_parameters")
    peer.wait_until(client.service_is_ready, "the parameters")
    unknown = ParameterMessage(name="update_rate", value=ParameterValue(type=77))
    client.call_async(SetParameters.Request(parameters=[unknown]))  # rclpy itself has no answer
    assert peer.put("update_rate", 200.0).successful
    peer.node.destroy_client(client)


def test_a_map_is_latched(server, peer):
    grid = peer.first(OccupancyGrid, "/map", LATCHED)
    occupied = {
        (
            round(grid.info.origin.position.x + (column + 0.5) * grid.info.resolution, 2),
            round(grid.info.origin.position.y + (row + 0.5) * grid.info.resolution, 2),
        )
        for row in range(grid.info.height)
        for column in range(grid.info.width)
        if grid.data[row * grid.info.width + column] == 100
    }
    assert (15.02, 0.03) in occupied or (15.03, 0.03) in occupied
    assert all(abs(y - 5.0) < 0.06 or abs(x - 15.0) < 0.06 for x, y in occupied)


def test_a_second_server_is_told(server, starts, peer):
    peer.wait_until(lambda: "flatland_server" in peer.names(), "the first server")
    second = starts[0]()
    text = "there is another node /flatland_server"
    peer.wait_until(lambda: text in second.log.read_text(), "the warning")


def test_scans_of_ten_robots_reach_all_kinds_of_readers(start, peer):
    topics = ["/scan", *(f"/r{n}/scan" for n in range(1, 10))]
    before = {topic: peer.received(LaserScan, topic, PATIENT) for topic in topics}  # reliable
    start()
    peer.wait_until(lambda: all(before.values()), "the first scans")
    best_effort = QoSProfile(depth=100, reliability=ReliabilityPolicy.BEST_EFFORT)
    after = {topic: peer.received(LaserScan, topic, best_effort) for topic in topics}
    with subprocess.Popen(
        [sys.executable, "-c", STALLED, *topics], stdout=subprocess.PIPE
    ) as stalled:
        # It may start for longer than this process's readers keep scans, which are read meanwhile.
        peer.wait_until(lambda: select.select([stalled.stdout], [], [], 0)[0], "its first scan")
        assert stalled.stdout.readline()
        stalled.send_signal(signal.SIGSTOP)
        counts = {topic: len(each) for topic, each in after.items()}
        peer.wait_until(
            lambda: all(len(each) >= counts[topic] + 60 for topic, each in after.items()),
            "600 scans beside a reader that is stopped",
        )
        stalled.kill()

    for each in (*before.values(), *after.values()):
        times = [scan.header.stamp.sec * 10 + scan.header.stamp.nanosec // 10**8 for scan in each]
        assert times == list(range(times[0], times[0] + len(each)))
        assert len(each[0].ranges) == 1082


def test_timers_of_simulated_time(start, peer):
    start()
    timed = Peer(parameter_overrides=[Parameter("use_sim_time", value=True)])
    ticks = []

    def rate():
        """Simulated time in real time, by ten periods of a timer."""
        ticks.clear()
        timed.wait_until(lambda: ticks, "a tick")
        began = time.monotonic()
        timed.wait_until(lambda: len(ticks) > 10, "ten periods")
        passed = time.monotonic() - began
        simulated = (ticks[10] - ticks[0]) * 1e-9
        assert simulated > 1.8  # more if the machine was busy: a late timer leaves periods out
        return simulated / passed

    timed.node.create_timer(0.2, lambda: ticks.append(timed.node.get_clock().now().nanoseconds))
    assert rate() < 2.0  # it is 1; on a busy machine, ticks that were late come together
    assert peer.put("update_rate", 1000.0).successful
    assert rate() > 2.0  # it is 5 on a machine with time for it
    peer.call(Empty, "/pause")
    clocks = timed.received(Clock, "/clock")
    timed.wait_until(lambda: clocks, "the time of the pause")
    ticks.clear()
    clocks.clear()
    timed.wait_until(lambda: len(clocks) > 2, "the time again, for nodes that come in a pause")
    assert ticks == []
    assert len({clock.clock.nanosec for clock in clocks}) == 1
    timed.node.destroy_node()


def test_remaps_namespaces_and_quality_of_service(start, peer):
    depth = "qos_overrides./sim/lidar.publisher.reliability:=best_effort"
    start("-r", "__ns:=/sim", "-r", "scan:=lidar", "-p", depth)

    def info():
        return peer.node.get_publishers_info_by_topic("/sim/lidar")

    [publisher] = peer.wait_until(info, "/sim/lidar")
    assert publisher.qos_profile.reliability.name == "BEST_EFFORT"
    peer.wait_until(
        lambda: ("flatland_server", "/sim") in peer.node.get_node_names_and_namespaces(), "/sim"
    )
    peer.call(Empty, "/sim/pause")
    peer.first(Clock, "/clock")


def test_it_leaves_the_graph_at_once(start, peer):
    process = start()
    peer.first(LaserScan, "/scan")
    process.send_signal(signal.SIGINT)
    assert process.wait(5) == 0
    began = time.monotonic()
    peer.wait_until(lambda: "flatland_server" not in peer.names(), "the end")
    assert time.monotonic() < began + 2.0


def test_after_sigkill_it_leaves_the_graph_with_its_lease(start, peer, tmp_path, monkeypatch):
    profile = tmp_path / "short_lease.xml"
    profile.write_text(SHORT_LEASE)
    for name in ("FASTRTPS_DEFAULT_PROFILES_FILE", "FASTDDS_DEFAULT_PROFILES_FILE"):
        monkeypatch.setenv(name, str(profile))
    process = start()
    peer.first(LaserScan, "/scan")
    process.kill()
    began = time.monotonic()
    peer.wait_until(lambda: "flatland_server" not in peer.names(), "the end")
    assert time.monotonic() < began + 5.0


@pytest.mark.parametrize(
    ("parameters", "text"),
    [
        ({"world_pth": "x"}, 'unknown parameter world_pth (did you mean "world_path"?)'),
        ({"cmd_vel_type": "Joy"}, "expected Twist or TwistStamped, found Joy"),
    ],
)
def test_wrong_parameters_end_the_node_with_a_reason(start, parameters, text):
    process = start(**parameters)
    assert process.wait(LIMIT) == 1
    assert text in process.log.read_text()


if __name__ == "__main__":
    sys.exit(pytest.main([str(Path(__file__)), *sys.argv[1:]]))
