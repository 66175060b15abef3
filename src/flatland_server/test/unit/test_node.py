"""A plugin's node: names, topics that are closed with it, and one publisher for each frame."""

import sys
from typing import Any, List

import pytest
from logged import warnings

from flatland_server import messages
from flatland_server.geometry import Pose, Transform
from flatland_server.transport.claims import FrameRegistry
from flatland_server.transport.local_transport import LocalTransport
from flatland_server.transport.node import Node

TFMessage = messages.get("tf2_msgs/TFMessage")
TransformStamped = messages.get("geometry_msgs/TransformStamped")


@pytest.fixture
def transport() -> LocalTransport:
    return LocalTransport(params={"/robot/gain": 2.0, "/gain": 1.0})


@pytest.fixture
def root(transport) -> Node:
    return Node(transport)


@pytest.mark.parametrize(
    ("namespace", "topic", "expected"),
    [
        ("", "scan", "/scan"),
        ("robot", "scan", "/robot/scan"),
        ("/robot/", "scan", "/robot/scan"),
        ("robot", "/scan", "/scan"),
        ("fleet/robot", "odometry/filtered", "/fleet/robot/odometry/filtered"),
    ],
)
def test_topics_get_the_namespace_unless_they_begin_with_a_slash(
    root, transport, namespace, topic, expected
):
    node = root.scoped(namespace, "plugin")
    received: List[Any] = []

    node.advertise(topic, str).publish("out")
    node.subscribe(topic, str, received.append)
    transport.send(expected, "in")
    transport.process()

    assert transport.topics == {expected}
    assert transport.last(expected) == "out"
    assert received == ["in"]


def test_a_namespace_within_a_namespace_is_appended_to_it(root):
    assert root.scoped("fleet", "a").scoped("robot", "b").resolve("scan") == "fleet/robot/scan"


def test_parameters_are_looked_up_in_the_namespace(root):
    node = root.scoped("robot", "plugin")

    assert node.get_param("gain") == 2.0
    assert node.get_param("/gain") == 1.0
    assert node.get_param("mass", 3.0) == 3.0


def test_a_closed_node_leaves_no_topic_behind(root, transport):
    node, other = root.scoped("", "plugin"), root.scoped("", "other")
    received: List[Any] = []
    node.advertise("scan", str).publish("a scan")
    node.advertise("shared", str)
    other.advertise("shared", str).publish("still there")
    node.subscribe("cmd_vel", str, received.append)

    node.close()
    deliver(transport, "cmd_vel")

    assert transport.topics == {"/shared"}
    assert transport.last("/shared") == "still there"
    assert transport.last("/scan") is None
    assert transport.subscribed == set()
    assert received == []


def test_messages_wait_until_they_are_processed_in_order(root, transport):
    received: List[Any] = []
    root.subscribe("cmd_vel", str, received.append)

    transport.send("cmd_vel", "first")
    transport.send("cmd_vel", "second")
    assert received == []
    transport.process()

    assert received == ["first", "second"]


def test_each_further_publisher_of_a_frame_causes_one_warning(root, caplog):
    nodes = [root.scoped("", f"robot{i}/drive") for i in range(3)]

    for _ in range(5):
        for parent, node in zip(("odom", "map", "odom"), nodes):
            node.send_transform(Transform(0, parent, "base", Pose()))

    first, _ = warnings(caplog)
    for word in ('"base"', "robot0/drive", '"odom"', "robot1/drive", '"map"'):
        assert word in first


def test_a_node_may_publish_several_frames_repeatedly(root, transport, caplog):
    node = root.scoped("", "robot/tf")

    for nanoseconds in (0, 1):
        for child in ("left", "right"):
            node.claim_frame("base", child)
            node.send_transform(Transform(nanoseconds, "base", child, Pose()))

    assert warnings(caplog) == []
    assert {child: t.nanoseconds for child, t in transport.transforms.items()} == {
        "left": 1,
        "right": 1,
    }


@pytest.fixture
def fleet() -> LocalTransport:
    transport = LocalTransport()
    transport.tf_by_namespace = True
    return transport


def frames(message: Any) -> List[Any]:
    return [(each.header.frame_id, each.child_frame_id) for each in message.transforms]


def test_each_namespace_may_have_transforms_of_its_own(fleet, caplog):
    registry = FrameRegistry()
    root = Node(fleet, frames=registry)
    nodes = [root.scoped(name, f"{name}/drive") for name in ("", "r1", "r2")]

    for node in nodes:
        opened = node.open_frames((node.name_frame("odom"), "base"))
        node.claim_odometry_frame("odom")
        node.send_transform(Transform(7, "base", "laser", Pose(1.0)))
        opened.send(7, [Pose(2.0)])
    fleet.flush()

    assert set(fleet.transforms) == {"base", "laser"}
    for topic in ("/r1/tf", "/r2/tf"):
        assert frames(fleet.last(topic)) == [("base", "laser"), ("odom", "base")]
    assert [each.transform.translation.x for each in fleet.last("/r1/tf").transforms] == [1.0, 2.0]
    assert registry.odometry_frames == {("", "odom"), ("r1", "odom"), ("r2", "odom")}
    assert warnings(caplog) == []

    nodes[2].close()
    assert fleet.topics == {"/r1/tf"}
    assert registry.odometry_frames == {("", "odom"), ("r1", "odom")}
    fleet.flush()


def test_two_publishers_of_a_frame_in_a_namespace_are_found(fleet, caplog):
    root = Node(fleet)
    nodes = [root.scoped("r1", f"r1/{plugin}") for plugin in ("drive", "tf")]
    for node in nodes:
        node.claim_frame("odom", "base")

    [message] = warnings(caplog)
    assert "switch one of them off" in message


def test_each_namespace_has_one_message_of_static_transforms(fleet):
    root = Node(fleet)
    for namespace, children in (("", "a"), ("r1", "bc")):
        for child in children:
            transform = TransformStamped(child_frame_id=child)
            transform.header.frame_id = "base"
            node = root.scoped(namespace, f"{namespace}/{child}")
            node.advertise("/tf_static", TFMessage, latch=True).publish(TFMessage([transform]))

    assert frames(fleet.last_latched("/tf_static")) == [("base", "a")]
    assert frames(fleet.last_latched("/r1/tf_static")) == [("base", "b"), ("base", "c")]


def test_a_namespace_without_transforms_has_no_topic_for_them(fleet):
    Node(fleet).scoped("r1", "r1/bumper").advertise("collisions", str)

    assert fleet.topics == {"/r1/collisions"}


def test_a_closed_node_releases_its_frames(root, caplog):
    first, second, third = (root.scoped("", f"robot{i}/drive") for i in range(3))
    first.claim_frame("odom", "base")

    first.close()
    second.claim_frame("odom", "base")
    assert warnings(caplog) == []

    third.claim_frame("map", "base")
    [message] = warnings(caplog)
    assert "robot1/drive" in message
    assert "robot0/drive" not in message


class Stop(BaseException):
    """Like KeyboardInterrupt, not an Exception."""


def fail(_: Any) -> None:
    raise RuntimeError("no luck")


def deliver(transport: LocalTransport, topic: str) -> None:
    transport.send(topic, "go")
    transport.process()


def test_a_failing_callback_does_not_keep_others_from_a_message(root, transport):
    robot, other = root.scoped("robot", "robot/drive"), root.scoped("", "other")
    failures: List[Any] = []
    received: List[Any] = []
    robot.on_failure = lambda where: failures.append((where, str(sys.exc_info()[1])))
    robot.subscribe("cmd_vel", str, fail)
    other.subscribe("/robot/cmd_vel", str, received.append)

    deliver(transport, "/robot/cmd_vel")

    assert failures == [("its callback of robot/cmd_vel", "no luck")]
    assert received == ["go"]


def test_a_failing_callback_raises_if_the_node_has_no_on_failure(root, transport):
    root.subscribe("cmd_vel", str, fail)

    with pytest.raises(RuntimeError, match="no luck"):
        deliver(transport, "cmd_vel")


def test_an_interrupt_in_a_callback_is_not_a_failure(root, transport):
    def stop(_: Any) -> None:
        raise Stop

    failures: List[str] = []
    root.on_failure = failures.append
    root.subscribe("cmd_vel", str, stop)

    with pytest.raises(Stop):
        deliver(transport, "cmd_vel")
    assert failures == []


def test_a_node_closed_by_a_callback_misses_that_message(root, transport):
    first, second = root.scoped("", "first"), root.scoped("", "second")
    received: List[Any] = []
    first.subscribe("cmd_vel", str, lambda _: second.close())
    second.subscribe("cmd_vel", str, received.append)

    deliver(transport, "cmd_vel")

    assert received == []


def test_a_node_lists_its_topics_until_it_is_closed(root):
    node = root.scoped("robot", "plugin")
    node.advertise("scan", "sensor_msgs/LaserScan")
    node.subscribe("cmd_vel", "geometry_msgs/Twist", print)
    root.advertise("other", str)

    assert node.topics == [
        ("/robot/scan", "sensor_msgs/LaserScan", True),
        ("/robot/cmd_vel", "geometry_msgs/Twist", False),
    ]
    node.close()
    assert node.topics == []
