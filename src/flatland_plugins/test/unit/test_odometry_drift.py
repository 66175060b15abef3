"""Odometry that drifts over time and along the path, as that of slipping wheels does.

The twist is what the wheels measure, and the pose its integral.
"""

import math
from types import SimpleNamespace
from typing import Any, List, Sequence, Tuple

import numpy as np
import pytest
from readings import FILTERED, GROUND_TRUTH, TWIST, assert_covariance, pose_of, twist_of

from flatland_plugins.odometry_config import DriftVariances
from flatland_server._core import World
from flatland_server.geometry import Pose

pytestmark = pytest.mark.slow

DRIVE = "type: DiffDrive, name: drive, body: base"
COUNT = 300

KEYS = (
    "odom_drift: {translation_per_metre: 0.01, translation_per_radian: 0.02, "
    "rotation_per_metre: 0.03, rotation_per_radian: 0.04}"
)
NOISE = "odom_pose_noise: [0.1, 0.2, 0.3], odom_twist_noise: [0.4, 0.5, 0.6]"
DRIFT = "odom_drift: [0.04, 0.01, 0.0025]"


def at_rest(_: float) -> Pose:
    return Pose(3.0, -2.0, 0.5236)


def straight(metres: float) -> Pose:
    return Pose(metres, 0.0, 0.0)


def sideways(metres: float) -> Pose:
    return Pose(0.0, metres, 0.0)


def on_the_spot(radians: float) -> Pose:
    return Pose(0.0, 0.0, radians).wrapped()


def circle(radians: float) -> Pose:
    """A pose on a circle of 1 m radius, counter-clockwise, beginning along the x axis."""
    return Pose(math.sin(radians), 1.0 - math.cos(radians), radians).wrapped()


def errors(variances: DriftVariances, path: Any, length: float, parts: int, seconds: float = 1.0):
    """Odometry errors of many robots at the end of a path in `parts` steps: x, y and yaw."""
    world = World()
    robots = [world.add_body("kinematic", path(0.0)) for _ in range(COUNT)]
    drifts = [variances.add_to(SimpleNamespace(physics_body=r), k) for k, r in enumerate(robots)]
    dt = seconds / parts
    for i in range(parts):
        here, there = Pose(*robots[0].pose), path(length * (i + 1) / parts)
        turn = math.remainder(there.yaw - here.yaw, math.tau)
        for robot in robots:
            robot.velocity = ((there.x - here.x) / dt, (there.y - here.y) / dt, turn / dt)
        world.step(dt)
    truth = Pose(*robots[0].pose)
    x, y, yaw = np.array([drift.pose for drift in drifts]).T
    turn = np.remainder(yaw - truth.yaw + math.pi, math.tau) - math.pi
    return np.array([x - truth.x, y - truth.y, turn]).T


# The variances depend on the path and on the time, not on their division.
DIVISIONS = pytest.mark.parametrize("parts", [5, 60])


@DIVISIONS
def test_a_robot_at_rest_drifts_by_variances_per_second(parts):
    ahead, left, turn, seconds = 0.04, 0.01, 0.0, 2.0

    error = errors(DriftVariances(per_second=(ahead, left, turn)), at_rest, 0.0, parts, seconds)

    axes = np.array([[math.cos(0.5236), -math.sin(0.5236)], [math.sin(0.5236), math.cos(0.5236)]])
    assert_covariance(error[:, :2], axes @ np.diag([ahead, left]) @ axes.T * seconds)
    assert np.abs(error[:, 2]).max() < 1e-9


@DIVISIONS
def test_a_heading_that_drifts_bends_a_straight_path(parts):
    time, path, q = 4.0, 2.0, 1e-3

    error = errors(DriftVariances(per_second=(0.0, 0.0, q)), straight, path, parts, time)

    # To first order, the heading is q's random walk and the path's lateral error its integral:
    # variances q t and v^2 q t^3 / 3, covariance v q t^2 / 2.
    covariance = q * time * np.array([[path**2 / 3, path / 2], [path / 2, 1.0]])
    assert_covariance(error[:, 1:], covariance)


@DIVISIONS
@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_a_robot_that_drives_straight_on_errs_by_the_metre(parts, direction):
    a1, a3, s = 0.01, 1e-4, 4.0
    variances = DriftVariances(translation_per_metre=a1, rotation_per_metre=a3)

    error = errors(variances, straight, direction * s, parts)

    # To first order, the heading is a random walk along the path, and the lateral error its
    # integral: variances a3 s and a3 s^3 / 3, covariance a3 s^2 / 2.
    bend = direction * a3 * s**2 / 2
    assert_covariance(error, [[a1 * s, 0, 0], [0, a3 * s**3 / 3, bend], [0, bend, a3 * s]])


@DIVISIONS
def test_sideways_motion_errs_in_the_direction_of_travel(parts):
    error = errors(DriftVariances(translation_per_metre=0.01), sideways, 4.0, parts)

    assert np.abs(error[:, [0, 2]]).max() < 1e-9
    assert_covariance(error[:, 1:2], [[0.04]])


@pytest.mark.parametrize(("parts", "direction"), [(50, 1.0), (50, -1.0), (120, 1.0)])
def test_a_robot_that_turns_on_the_spot_errs_by_the_radian(parts, direction):
    a2, a4, turn = 1e-4, 1e-3, 3 * math.tau
    variances = DriftVariances(translation_per_radian=a2, rotation_per_radian=a4)

    error = errors(variances, on_the_spot, direction * turn, parts)

    # Along the body's x axis, which points everywhere alike in the course of whole turns.
    x_and_y = a2 * turn / 2
    assert_covariance(error, np.diag([x_and_y, x_and_y, a4 * turn]))


@pytest.mark.parametrize("parts", [6, 60])
def test_a_robot_on_a_circle_errs_by_the_metre_and_the_radian(parts):
    turn = math.pi / 2
    variances = DriftVariances(rotation_per_metre=2e-4, rotation_per_radian=1e-4)

    error = errors(variances, circle, turn, parts)

    # To first order, an error of the heading at an angle t turns what follows of the circle, p(T) -
    # p(t), by a quarter turn: the integrals of (cos T - cos t, sin T - sin t, 1) and its products.
    t = (np.arange(10_000) + 0.5) / 10_000 * turn
    rows = np.array([np.cos(turn) - np.cos(t), np.sin(turn) - np.sin(t), np.ones_like(t)])
    assert_covariance(error, 3e-4 * turn * (rows @ rows.T) / len(t))


@pytest.mark.parametrize("keys", ["", ", pub_rate: 20"])
def test_a_parked_robot_in_a_world_does_not_drift_at_all(files, keys):
    robot = files.robot(f"{DRIVE}, {KEYS}{keys}", pose="[3, -2, 1]").run(2.0)
    assert robot.last(FILTERED).pose == robot.last(GROUND_TRUTH).pose  # it begins at the truth

    robot.drive(0.5, 0.5).run(1.0)
    robot.drive(0.0).run(0.1)
    parked = robot.last(FILTERED).pose
    robot.run(5.0)

    assert robot.last(FILTERED).pose == parked
    assert robot.last(GROUND_TRUTH).pose != parked


def test_moving_a_robot_moves_its_estimate_without_error(files):
    robot = files.robot(f"{DRIVE}, {KEYS}").drive(0.5).run(2.0)
    robot.drive(0.0).run(0.1)
    before = Pose(*pose_of(robot.last(FILTERED)))
    there = robot.model().pose.inverse().compose(Pose(50.0, -20.0, 2.0))

    robot.world.move_model("robot", Pose(50.0, -20.0, 2.0))
    robot.run()

    expected = before.compose(there).wrapped()
    assert pose_of(robot.last(FILTERED)) == pytest.approx(tuple(expected), abs=1e-4)


def record(files, keys: str) -> List[Any]:
    return files.robot(f"{DRIVE}, {keys}", seed=5).drive(0.5, 0.3).record(FILTERED, 1.0)


def test_a_list_is_the_drift_per_second(files):
    in_a_map = record(files, "odom_drift: {per_second: [0.1, 0.2, 0.3]}")

    assert record(files, "odom_drift: [0.1, 0.2, 0.3]") == in_a_map


def test_drifts_of_both_kinds_add_up(files):
    both = KEYS.replace("}", ", per_second: [0.1, 0.1, 0.1]}")
    robot = files.robot(f"{DRIVE}, {both}").run()

    first, second = (robot.run(0.5).last(FILTERED).pose for _ in range(2))

    assert first != second  # at rest


def test_there_is_no_drift_by_default(files):
    assert record(files, NOISE) == record(files, f"{NOISE}, odom_drift: [0, 0, 0]")
    robot = files.robot(DRIVE).drive(0.5, 0.3).run(1.0)
    assert pose_of(robot.last(FILTERED)) == pose_of(robot.last(GROUND_TRUTH))


def test_a_drift_leaves_the_truth_and_the_noise_as_they_are(files):
    def run(keys: str) -> List[Tuple[Any, ...]]:
        robot = files.robot(f"{DRIVE}, {keys}", seed=5).drive(0.5, 0.3)
        topics = (FILTERED, GROUND_TRUTH, TWIST)
        return [tuple(map(robot.run().last, topics)) for _ in range(200)]

    for (both, truth, twist), (drifted, _, measured), (noisy, same_truth, noisy_twist) in zip(
        run(f"{NOISE}, {DRIFT}"), run(DRIFT), run(NOISE)
    ):
        assert truth == same_truth
        # The white noise is the same, about the pose that has drifted and the twist of the wheels.
        for a, b, c, d in zip(*map(pose_of, (both, drifted, noisy, truth))):
            assert math.remainder(a - b - (c - d), math.tau) == pytest.approx(0.0, abs=1e-9)
        for a, b, c, d in zip(*map(twist_of, (twist, measured, noisy_twist, truth))):
            assert a - b == pytest.approx(c - d, abs=1e-9)


def after(pose: Pose, velocity: Sequence[float], dt: float) -> Pose:
    """The pose after a constant velocity in the body's frame: a chord at half the turn."""
    vx, vy, omega = velocity
    half = Pose(0.0, 0.0, omega * dt / 2)
    return pose.compose(half).compose(Pose(vx * dt, vy * dt, 0.0)).compose(half)


BIASES = "wheel_radius_bias: 0.02, track_width_bias: 0.02, curvature_bias: 0.05"


@pytest.mark.parametrize("drive", ["DiffDrive", "OmniDrive"])
@pytest.mark.parametrize("rate", [30, 200])
def test_the_pose_is_the_integral_of_the_twist(files, drive, rate):
    keys = KEYS.replace("}", f", per_second: [0.01, 0.01, 0.01], {BIASES}}}")
    robot = files.robot(f"type: {drive}, name: drive, body: base, {keys}, pub_rate: {rate}", seed=3)
    first, *messages = robot.drive(0.5, 0.4).record(FILTERED, 5.0)

    pose, time = Pose(*pose_of(first)), first.header.stamp.to_sec()
    for message in messages:
        stamp = message.header.stamp.to_sec()
        pose, time = after(pose, twist_of(message), stamp - time), stamp
        # Slip between two messages bends the path: to second order, not seen in their mean.
        assert np.subtract(pose_of(message)[:2], pose[:2]) == pytest.approx(0.0, abs=0.02)
        assert abs(math.remainder(pose_of(message)[2] - pose.yaw, math.tau)) < 1e-6

    truth = pose_of(robot.last(GROUND_TRUTH))
    assert math.dist(truth[:2], pose_of(message)[:2]) > 0.1


def test_a_bias_is_one_of_the_run_and_scales_what_is_measured(files):
    measured = []
    for seed in (1, 2, 2):
        robot = files.robot(f"{DRIVE}, odom_drift: {{{BIASES}}}", seed=seed).drive(0.5, 0.4)
        early, late = (twist_of(robot.run(each).last(TWIST)) for each in (1.0, 2.0))
        assert late == pytest.approx(early, abs=1e-4)
        measured.append(late)

    assert measured[0] != measured[1] == measured[2]
    assert measured[0] != pytest.approx((0.5, 0.0, 0.4), abs=1e-3)


@pytest.mark.parametrize("keys", ["odom_drift: [1, 1, 1]", "odom_pose_noise: [1, 1, 1]"])
def test_the_transform_is_the_odometry_of_the_message(files, keys):
    robot = files.robot(f"{DRIVE}, {keys}", pose="[3, -2, 1]").drive(1.0, 1.0).run(0.5)

    odometry, transform = robot.last(FILTERED), robot.transport.transforms["base"]
    assert tuple(transform.pose) == pytest.approx(tuple(pose_of(odometry)), abs=1e-9)
    assert (transform.parent, transform.roll) == (odometry.header.frame_id, 0.0)
    assert transform.nanoseconds == odometry.header.stamp.to_nsec()
    assert transform.pose.x != pytest.approx(robot.model().pose.x, abs=1e-3)


def test_a_twist_in_the_odometry_frame_uses_the_drifted_heading(files):
    robot = files.robot(f"{DRIVE}, odom_drift: [0, 0, 1], twist_in_local_frame: false")

    robot.drive(1.0).run(1.0)

    message = robot.last(FILTERED)
    velocity, yaw = message.twist.twist.linear, pose_of(message)[2]
    assert (velocity.x, velocity.y) == pytest.approx((math.cos(yaw), math.sin(yaw)), abs=1e-3)
    assert abs(yaw) > 0.1


def test_the_estimate_does_not_depend_on_how_often_it_is_read(files):
    estimates = []
    for keys, reads in (("", 1), (", pub_rate: 3", 1), (", pub_rate: 3", 50)):
        robot = files.robot(f"{DRIVE}, {KEYS}{keys}", seed=5).drive(0.5, 0.3)
        [plugin] = robot.world.plugins_of("robot").values()
        for _ in range(reads):
            estimate = plugin.read(robot.run(1.0 / reads).timekeeper)
        estimates.append(estimate)
    poses = [estimate.pose for estimate in estimates]

    assert poses[0] == poses[1] == poses[2]
    assert estimates[1] == estimates[2] != estimates[0]  # the mean of the time since an update
