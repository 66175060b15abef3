"""PosePublisher: the pose of a body in the world, also by the keys of other simulators."""

import pytest
from logged import warnings

from flatland_server import Pose, yaw_of

MODEL = """
bodies:
  - {name: base, footprints: [{type: circle, radius: 0.1, density: 1}]}
  - {name: arm, pose: [1, 2, 0.5], footprints: [{type: circle, radius: 0.1, density: 1}]}
plugins:
"""


def load(files, plugin, namespace=""):
    files.write("robot.yaml", f"{MODEL}  - {{{plugin}}}\n")
    entry = f"model: robot.yaml, namespace: '{namespace}', pose: [10, 20, 0.25]"
    return files.load_models({"robot": entry})


def pose_of(message):
    return message.pose.position.x, message.pose.position.y, yaw_of(message.pose.orientation)


def test_the_pose_is_that_of_the_body_in_the_world(files):
    robot = load(files, "type: PosePublisher, name: pose, body: arm", "ns").run()

    message = robot.last("/ns/pose")

    x, y = Pose(10.0, 20.0, 0.25).apply(1.0, 2.0)
    assert pose_of(message) == pytest.approx((x, y, 0.75), abs=1e-5)
    assert message.header.frame_id == "map"


def test_poses_come_at_their_rate_along_the_way(files):
    robot = load(files, "type: PosePublisher, name: pose, topic: place, world_frame_id: world")
    robot.model().base.physics_body.velocity = (0.5, -1.0, 0.0)

    poses = robot.record("/place", 1.0)

    assert len(poses) == 10
    for pose in poses:
        seconds = pose.header.stamp.to_sec()
        expected = (10 + 0.5 * seconds, 20 - seconds, 0.25)
        assert pose_of(pose) == pytest.approx(expected, abs=1e-3)
        assert pose.header.frame_id == "world"


def test_names_and_keys_of_the_original_pose_pub_are_accepted(files, caplog):
    keys = "ground_truth_pub: truth, pub_rate: 20, odom_frame_id: odom, odom_pub: odom"
    robot = load(files, f"type: PosePub, name: pose, body: base, {keys}")

    poses = robot.record("/truth", 1.0)

    assert len(poses) == 20
    assert pose_of(poses[-1]) == pytest.approx((10, 20, 0.25), abs=1e-5)
    [warning] = warnings(caplog)
    assert warning.endswith('plugins[0] "pose": no effect: odom_frame_id and odom_pub')
