"""Odometry that drifts over time: its size, its propagation, and values without drift."""

import math
from typing import Any, List, Tuple

import numpy as np
import pytest
from readings import FILTERED, GROUND_TRUTH, TWIST, assert_covariance

from flatland_server.geometry import Pose
from flatland_server.timekeeper import Timekeeper

DRIVE = "type: DiffDrive, name: drive, body: base"
NOISE = "odom_pose_noise: [0.1, 0.2, 0.3], odom_twist_noise: [0.4, 0.5, 0.6]"
DRIFT = "odom_drift: [0.04, 0.01, 0.0025]"
GHOST = "{type: circle, radius: 0.2, density: 10, layers: []}"


def pose_of(odometry: Any) -> Pose:
    position, q = odometry.pose.pose.position, odometry.pose.pose.orientation
    return Pose(position.x, position.y, 2.0 * math.atan2(q.z, q.w)).wrapped()


def swarm(files, count: int, keys: str, pose: str = "[0, 0, 0]", step: float = 0.005):
    """Robots that pass through each other and obey one topic, each with noise of its own."""
    model = files.model("robot", f"{DRIVE}, twist_sub: /cmd_vel, {keys}", footprint=GHOST)
    names = [f"r{i}" for i in range(count)]
    robots = files.load_models(
        {n: f"model: {model}, namespace: {n}, pose: {pose}" for n in names}, seed=3
    )
    robots.timekeeper = Timekeeper(step)
    return robots


def run_to_a_message(robots, seconds: float):
    """Runs without subscribers, while drifts accumulate, and one step more for the messages."""
    robots.transport.set_subscribed_topics(())
    robots.run(seconds)
    robots.transport.set_subscribed_topics(None)
    return robots.run()


def estimated(robots) -> List[Pose]:
    """The pose in each robot's last odometry."""
    return [pose_of(robots.last(f"/{name}{FILTERED}")) for name in robots.world.models]


def errors(robots) -> np.ndarray:
    """Each robot's odometry less the truth, in the world's frame: a row of x, y and yaw."""
    rows = []
    for name, (x, y, yaw) in zip(robots.world.models, estimated(robots)):
        truth = pose_of(robots.last(f"/{name}{GROUND_TRUTH}"))
        rows.append((x - truth.x, y - truth.y, math.remainder(yaw - truth.yaw, math.tau)))
    return np.array(rows)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("rate", "step", "seconds"),
    [("inf", 0.005, 0.1), ("inf", 0.02, 0.4), ("40", 0.005, 0.5), ("7", 0.02, 2.0), ("1", 0.05, 4)],
)
def test_a_robot_at_rest_drifts_by_its_variances_per_second(files, rate, step, seconds):
    variances = np.array([0.04, 0.01, 0.0025])
    robots = swarm(files, 150, f"{DRIFT}, pub_rate: {rate}", pose="[3, -2, 1]", step=step)

    robots.run(step)
    poses, stamps = [estimated(robots)], [0.0]
    for _ in range(5):
        poses.append(estimated(run_to_a_message(robots, seconds - step)))
        stamps.append(robots.last(f"/r0{FILTERED}").header.stamp.to_sec())

    # The motions that a robot estimates, between these times, in its own frame.
    moved = np.array(
        [
            [before.inverse().compose(after).wrapped() for before, after in zip(*pair)]
            for pair in zip(poses, poses[1:])
        ]
    )
    scaled = moved / np.sqrt(np.outer(np.diff(stamps), variances))[:, None, :]
    assert stamps[-1] == pytest.approx(5 * seconds)
    assert_covariance(scaled.reshape(-1, 3), np.eye(3))
    # Consecutive intervals are uncorrelated.
    pairs = (scaled[1:] * scaled[:-1]).reshape(-1, 3)
    assert np.abs(pairs.sum(axis=0)).max() < 4 * math.sqrt(len(pairs))
    # The total is the variance per second times the time, about the robots' true pose.
    x, y, yaw = (np.array(poses[-1]) - [3, -2, 1]).T
    ahead, left = math.cos(1) * x + math.sin(1) * y, math.cos(1) * y - math.sin(1) * x
    assert_covariance(np.array([ahead, left, yaw]).T, np.diag(variances * stamps[-1]))


@pytest.mark.slow
@pytest.mark.parametrize("rate", [20, 1])
def test_a_heading_that_drifts_bends_a_straight_path(files, rate):
    time, speed, q = 4.0, 0.5, 1e-3
    robots = swarm(files, 400, f"odom_drift: [0, 0, {q}], pub_rate: {rate}", step=0.025)

    run_to_a_message(robots.drive(speed), time)

    # To first order, the heading is q's random walk and the path's lateral error its integral:
    # variances q t and v^2 q t^3 / 3, covariance v q t^2 / 2.
    lateral_and_yaw = errors(robots)[:, 1:]
    path = speed * time
    covariance = q * time * np.array([[path**2 / 3, path / 2], [path / 2, 1.0]])
    assert_covariance(lateral_and_yaw, covariance)


def test_a_drift_is_in_the_bodys_frame(files):
    ahead, left = 0.01, 0.0025
    robots = swarm(
        files, 400, f"odom_drift: [{ahead}, {left}, 0], pub_rate: 20", "[1, 1, 0.5236]", 0.025
    )

    error = errors(run_to_a_message(robots, 1.0))

    axes = np.array([[math.cos(0.5236), -math.sin(0.5236)], [math.sin(0.5236), math.cos(0.5236)]])
    assert_covariance(error[:, :2], axes @ np.diag([ahead, left]) @ axes.T)
    assert np.abs(error[:, 2]).max() < 1e-9


def test_the_drift_begins_at_the_truth(files):
    robot = files.robot(f"{DRIVE}, odom_drift: [1, 1, 1]", pose="[3, -2, 1]").run()

    assert robot.last(FILTERED).pose == robot.last(GROUND_TRUTH).pose


@pytest.mark.parametrize("noise", ["pub_rate: 50", NOISE])
def test_there_is_no_drift_by_default(files, noise):
    runs = []
    for keys in (noise, f"{noise}, odom_drift: [0, 0, 0]"):
        robot = files.robot(f"{DRIVE}, {keys}", seed=5).drive(0.5, 0.3)
        runs.append(robot.record(FILTERED, 1.0))

    assert runs[0] == runs[1]
    if noise != NOISE:
        assert pose_of(robot.last(FILTERED)) == pose_of(robot.last(GROUND_TRUTH))


def test_a_drift_leaves_the_truth_the_twist_and_the_noise_as_they_are(files):
    def run(keys: str) -> List[Tuple[Any, ...]]:
        robot = files.robot(f"{DRIVE}, {keys}", seed=5).drive(0.5, 0.3)
        topics = (FILTERED, GROUND_TRUTH, TWIST)
        return [tuple(map(robot.run().last, topics)) for _ in range(200)]

    for (both, truth, twist), (drifted, _, _), (noisy, same_truth, same_twist) in zip(
        run(f"{NOISE}, {DRIFT}"), run(DRIFT), run(NOISE)
    ):
        assert (truth, twist, both.twist) == (same_truth, same_twist, noisy.twist)
        # The white noise is the same, about the pose that has drifted.
        for a, b, c, d in zip(*map(pose_of, (both, drifted, noisy, truth))):
            assert math.remainder(a - b - (c - d), math.tau) == pytest.approx(0.0, abs=1e-9)


def test_the_transform_drifts_as_the_message_does(files):
    robot = files.robot(f"{DRIVE}, odom_drift: [1, 1, 1]", pose="[3, -2, 1]").drive(1.0, 1.0)

    robot.run(0.5)

    transform = robot.transport.transforms["base"]
    assert tuple(transform.pose) == pytest.approx(tuple(pose_of(robot.last(FILTERED))), abs=1e-9)
    assert transform.pose.x != pytest.approx(robot.model().pose.x, abs=1e-3)


def test_a_twist_in_the_odometrys_frame_goes_by_the_drifted_heading(files):
    robot = files.robot(f"{DRIVE}, odom_drift: [0, 0, 1], twist_in_local_frame: false")

    robot.drive(1.0).run(1.0)

    message = robot.last(FILTERED)
    velocity, yaw = message.twist.twist.linear, pose_of(message).yaw
    assert (velocity.x, velocity.y) == pytest.approx((math.cos(yaw), math.sin(yaw)), abs=1e-3)
    assert abs(yaw) > 0.1
