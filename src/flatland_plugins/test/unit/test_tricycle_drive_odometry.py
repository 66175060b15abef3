"""TricycleDrive: odometry, its topics and frames."""

import math

import numpy as np
import pytest
from forklift import WHEELBASE, forklift, twist_at
from readings import FILTERED, GROUND_TRUTH, TWIST, pose_of, twist_of

from flatland_server.geometry import Pose


def test_odometry_is_that_of_the_body_at_the_front_wheel(files):
    robot = forklift(files, entry=", pose: [1, 2, 0.5]").drive(0.8, 0.5).run(2.0)

    truth, filtered = robot.last(GROUND_TRUTH), robot.last(FILTERED)

    assert twist_of(truth) == pytest.approx(twist_at(0.8, 0.5), abs=1e-3)
    assert twist_of(filtered) == twist_of(truth)
    robot.run()
    assert pose_of(robot.last(GROUND_TRUTH)) == pytest.approx(pose_of(truth), abs=1.5 * 0.8 * 0.005)
    x, y, _ = pose_of(truth)
    # About the centre of the turn, L / sin a from the front wheel.
    centre = Pose(1.0, 2.0, 0.5).apply(-WHEELBASE, WHEELBASE / math.tan(0.5))
    assert math.dist((x, y), centre) == pytest.approx(WHEELBASE / math.sin(0.5), abs=1e-3)


def test_frames_and_topics_are_the_documented_ones_and_there_is_no_twist(files):
    robot = forklift(files).run()

    assert robot.transport.subscribed == {"/cmd_vel"}
    assert robot.transport.topics == {FILTERED, GROUND_TRUTH}
    filtered, truth = robot.last(FILTERED), robot.last(GROUND_TRUTH)
    assert (filtered.header.frame_id, filtered.child_frame_id) == ("odom", "base")
    assert (truth.header.frame_id, truth.child_frame_id) == ("map", "base")
    assert robot.transport.transforms["base"].parent == "odom"


def test_the_twist_is_published_if_it_is_asked_for(files):
    robot = forklift(files, "enable_twist_pub: true").drive(0.8, 0.5).run(0.1)

    twist = robot.last(TWIST)

    assert robot.transport.topics == {FILTERED, GROUND_TRUTH, TWIST}
    assert twist.header.frame_id == "base"
    assert twist_of(twist) == pytest.approx(twist_at(0.8, 0.5), abs=1e-3)


def test_frames_and_topics_can_be_named(files):
    robot = forklift(
        files,
        "twist_sub: go",
        "odom_pub: a",
        "ground_truth_pub: b",
        "odom_frame_id: start",
        "ground_truth_frame_id: world",
    ).run()

    assert robot.transport.subscribed == {"/go"}
    assert robot.transport.topics == {"/a", "/b"}
    assert robot.last("/a").header.frame_id == "start"
    assert robot.last("/b").header.frame_id == "world"
    assert robot.transport.transforms["base"].parent == "start"


def test_a_namespace_is_put_before_topics_and_the_models_own_frames(files):
    robot = forklift(files, "ground_truth_pub: /truth", entry=", namespace: robot1")

    robot.drive(1.0, topic="/robot1/cmd_vel").run(1.0)

    assert robot.transport.topics == {f"/robot1{FILTERED}", "/truth"}
    odometry = robot.last(f"/robot1{FILTERED}")
    assert (odometry.header.frame_id, odometry.child_frame_id) == ("odom", "robot1_base")
    assert robot.transport.transforms["robot1_base"].parent == "odom"
    assert robot.model().pose.x == pytest.approx(1.0, abs=1e-3)


def test_odometry_has_the_noise_and_the_covariance_that_are_asked_for(files):
    noise = ("odom_pose_noise: [0.04, 0.01, 0.0025]", "odom_twist_noise: [0.09, 0.0004, 0.16]")
    robot = forklift(files, *noise, seed=7)

    messages = robot.record(FILTERED, 5.0)

    scaled = np.array([[*pose_of(m), *twist_of(m)] for m in messages])
    scaled /= np.sqrt([0.04, 0.01, 0.0025, 0.09, 0.0004, 0.16])
    count = len(scaled)
    # A sum of n squares of standard normals has the mean n and the variance 2 n (chi-squared).
    assert np.abs((scaled**2).sum(axis=0) - count).max() < 4 * math.sqrt(2 * count)
    diagonal = np.diag(np.reshape(messages[0].pose.covariance, (6, 6)))
    assert diagonal.tolist() == [0.04, 0.01, 0, 0, 0, 0.0025]
    diagonal = np.diag(np.reshape(messages[0].twist.covariance, (6, 6)))
    assert diagonal.tolist() == [0.09, 0.0004, 0, 0, 0, 0.16]


def test_nothing_is_published_that_nobody_listens_to(files, deaf_transport):
    forklift(files, transport=deaf_transport).drive(1.0, 0.5).run(0.1)

    assert deaf_transport.published == []
    assert deaf_transport.transforms == {}
