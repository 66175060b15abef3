"""Markers and transforms serialized by us, deserialized by ROS's own code."""

from pathlib import Path

import numpy as np
import pytest
from markers_of_worlds import markers_of_a_world
from std_msgs.msg import ColorRGBA
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray
from without_ros import run_without_ros

from flatland_server import _core
from flatland_server.geometry import Pose, Transform, quaternion
from flatland_server.messages.serialized_markers import (
    LazyMarkerArray,
    MovingMarkers,
    array_of,
    serialized,
)
from flatland_server.messages.wall_markers import flat_walls, upright_walls
from flatland_server.messages.wire_form import serialized as sent
from flatland_server.models.layer import LayerConfig
from flatland_server.transport.transforms import SerializedFrames, TransformQueue


def marker(namespace: str, **fields) -> Marker:
    made = Marker(ns=namespace, type=Marker.CYLINDER, color=ColorRGBA(1, 0, 0, 1), **fields)
    made.header.frame_id = "map"
    return made


def test_only_the_poses_of_moving_markers_change():
    markers = [marker("a/base", id=1), marker("büro/arm", id=2, text="hello")]
    poses = [Pose(1.0, 2.0, 0.5), Pose(-3.0, 4.0, -1.0)]

    received = MarkerArray().deserialize(sent(array_of([MovingMarkers(markers).place(poses)])))

    for one, original, pose in zip(received.markers, markers, poses):
        rotation = one.pose.orientation
        assert (one.pose.position.x, one.pose.position.y) == (pose.x, pose.y)
        found = (rotation.x, rotation.y, rotation.z, rotation.w)
        assert found == pytest.approx(quaternion(pose.yaw))
        one.pose = original.pose
        assert sent(one) == sent(original)


def test_arrays_are_joined():
    parts = [serialized([marker("a"), marker("b")]), serialized([]), serialized([marker("c")])]

    received = MarkerArray().deserialize(sent(array_of(parts)))

    assert [one.ns for one in received.markers] == ["a", "b", "c"]


def test_transforms_are_a_tf_message():
    transforms = [
        Transform(3_000_000_005, "odom", "robot1_base", Pose(1.0, -2.0, 2.5)),
        Transform(7, "base", "läser", Pose(0.1, 0.2, -0.5), 3.0),
    ]
    queue = TransformQueue()

    for _ in range(2):  # the second time with cached names
        for transform in transforms:
            queue.add(transform)
        received = TFMessage().deserialize(queue.take())

        assert queue.take() == b""
        assert len(received.transforms) == 2
        for one, transform in zip(received.transforms, transforms):
            assert one.header.stamp.to_nsec() == transform.nanoseconds
            assert (one.header.frame_id, one.child_frame_id) == (transform.parent, transform.child)
            position, rotation = one.transform.translation, one.transform.rotation
            assert (position.x, position.y, position.z) == (*transform.pose[:2], 0.0)
            expected = quaternion(transform.pose.yaw, transform.roll)
            assert (rotation.x, rotation.y, rotation.z, rotation.w) == expected


def test_open_frames_send_the_same_as_single_transforms():
    names = [("map", "läser"), ("odom", "robot1_base")]
    poses = [(1.0, -2.0, 2.5), (0.1, 0.2, -0.5)]
    quick, plain = TransformQueue(), TransformQueue()
    frames = SerializedFrames(quick, names)

    for nanoseconds in (7, 3_000_000_005):
        frames.send(nanoseconds, poses)
        quick.add(Transform(nanoseconds, "odom", "other", Pose()))
        for (parent, child), pose in zip(names, poses):
            plain.add(Transform(nanoseconds, parent, child, Pose(*pose)))
        plain.add(Transform(nanoseconds, "odom", "other", Pose()))

        assert quick.take() == plain.take()


def test_poses_read_by_the_core_are_sent_like_given_poses():
    world = _core.World()
    base, wheel, sensor = (
        world.add_body("dynamic", pose) for pose in [(1.0, -2.0, 9.5), (0.5, 0, -1), (3, 4, 2)]
    )
    for reference, bodies in ((None, [base]), (base, [wheel, sensor]), (None, [])):
        poses = _core.RelativePoses(reference, bodies)
        queue, plain = TransformQueue(), TransformQueue()
        names = [("bäse", f"frame_{i}") for i in range(len(bodies))]
        frames, plain_frames = SerializedFrames(queue, names), SerializedFrames(plain, names)
        for nanoseconds in (7, 3_000_000_005):
            base.velocity = (1.0, 0.5, 2.0)
            world.step(0.1)
            frames.send(nanoseconds, poses)
            plain_frames.send(nanoseconds, poses.read())

            assert queue.take() == plain.take()


def test_poses_of_another_number_of_bodies_are_refused():
    body = _core.World().add_body("dynamic", (0, 0, 0))
    frames = SerializedFrames(TransformQueue(), [("map", "a"), ("map", "b")])

    with pytest.raises(ValueError, match="expected the offsets of 1 bodies, found 2"):
        frames.send(7, _core.RelativePoses(None, [body]))


def test_a_message_of_a_body_that_is_gone_is_refused():
    body = _core.World().add_body("dynamic", (0, 0, 0))
    message = _core.BodyMessage(bytes(68), _core.RelativePoses(None, [body]), [(0, 12, None)])
    body.remove()

    with pytest.raises(_core.GoneError):
        message.data(7)


MARKERS = """
from pathlib import Path
from markers_of_worlds import markers_of_a_world
print(markers_of_a_world(Path(sys.argv[1])))
"""


@pytest.mark.slow
def test_without_ros_markers_have_the_same_bytes(tmp_path):
    data = run_without_ros(MARKERS, tmp_path).strip()

    assert data == markers_of_a_world(tmp_path)
    assert len(MarkerArray().deserialize(bytes.fromhex(data)).markers) == 7


# The walls of a layer

COLOR = (0.25, 0.5, 0.75, 1.0)
SEGMENTS = np.array([[0.0, 0.0, 4.0, 0.0], [4.0, 0.0, 4.0, 3.0]])


def config(min_z=0.0, max_z=1.0):
    return LayerConfig(("room", "hall"), 3, COLOR, min_z, max_z, Path("map.yaml"))


def received(message):
    return MarkerArray().deserialize(sent(message)).markers


def corners(marker):
    return [(p.x, p.y, p.z) for p in marker.points]


def test_flat_walls_are_lines_on_the_ground():
    [marker] = received(array_of([flat_walls(config(0.5, 2.0), SEGMENTS)]))

    assert (marker.type, marker.ns, marker.header.frame_id) == (Marker.LINE_LIST, "room", "map")
    assert (marker.color.r, marker.color.g, marker.color.b, marker.color.a) == COLOR
    assert marker.pose.orientation.w == 1.0
    assert corners(marker) == [(0, 0, 0), (4, 0, 0), (4, 0, 0), (4, 3, 0)]


def test_upright_walls_fill_the_height_above_each_segment():
    [marker] = received(array_of([upright_walls(config(0.5, 2.0), SEGMENTS)]))

    assert (marker.type, marker.ns, marker.header.frame_id) == (Marker.TRIANGLE_LIST, "room", "map")
    triangles = np.reshape(corners(marker), (-1, 3, 3))
    sides = triangles[:, 1:] - triangles[:, :1]
    areas = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1) / 2
    assert areas == pytest.approx([3.0, 3.0, 2.25, 2.25])  # halves of 4 x 1.5 and 3 x 1.5
    for (x1, y1, x2, y2), pair in zip(SEGMENTS, triangles.reshape(-1, 6, 3)):
        expected = {(x, y, z) for x, y in ((x1, y1), (x2, y2)) for z in (0.5, 2.0)}
        assert set(map(tuple, pair)) == expected


@pytest.mark.parametrize("max_z", [0.5, 0.2])
def test_walls_without_a_height_are_lines_at_min_z(max_z):
    [marker] = received(array_of([upright_walls(config(0.5, max_z), SEGMENTS)]))

    assert marker.type == Marker.LINE_LIST
    assert {z for _, _, z in corners(marker)} == {0.5}


@pytest.mark.parametrize("walls", [flat_walls, upright_walls])
def test_no_walls_are_no_marker(walls):
    """Rviz reports a marker without points as an error."""
    assert received(array_of([walls(config(), np.empty((0, 4)))])) == []


def test_a_lazy_array_is_made_when_it_is_sent():
    calls = []

    def make():
        calls.append(1)
        return array_of([flat_walls(config(), SEGMENTS)])

    message = LazyMarkerArray(make)

    assert calls == []
    assert [marker.ns for marker in received(message)] == ["room"]
    assert calls == [1]
