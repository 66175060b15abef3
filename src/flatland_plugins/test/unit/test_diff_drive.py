"""DiffDrive: motion by command and within limits; odometry with noise and without."""

import logging
import math
from typing import Any, Callable, Dict, List, Tuple

import numpy as np
import pytest
from geometry_msgs.msg import Twist

from flatland_server.timekeeper import Timekeeper

DRIVE = "type: DiffDrive, name: drive, body: base"
FILTERED, GROUND_TRUTH, TWIST = "/odometry/filtered", "/odometry/ground_truth", "/twist"


def yaw_of(message: Any) -> float:
    """The heading of a pose that is flat on the floor."""
    q = message.orientation
    assert (q.x, q.y) == (0.0, 0.0)
    return 2.0 * math.atan2(q.z, q.w)


def pose_of(odometry: Any) -> Tuple[float, float, float]:
    pose = odometry.pose.pose
    return pose.position.x, pose.position.y, yaw_of(pose)


def twist_of(stamped: Any) -> Tuple[float, float, float]:
    """The velocity in an Odometry or a TwistStamped."""
    twist = getattr(stamped.twist, "twist", stamped.twist)
    return twist.linear.x, twist.linear.y, twist.angular.z


def arc(linear: float, angular: float, time: float) -> Tuple[float, float, float]:
    """Where a constant velocity leads from the origin, in closed form."""
    turned = angular * time
    if angular == 0.0:
        return linear * time, 0.0, 0.0
    radius = linear / angular
    heading = math.remainder(turned, math.tau)
    return radius * math.sin(turned), radius * (1 - math.cos(turned)), heading


def path_of(speed: Dict[float, float], turn: Dict[float, float], duration: float) -> np.ndarray:
    """Time, x, y and yaw of a body whose speed and yaw rate change evenly between given times."""
    grid, h = np.linspace(0.0, duration, 100_001, retstep=True)
    v, omega = (np.interp(grid, list(curve), list(curve.values())) for curve in (speed, turn))
    # The trapezoidal rule: exact for the yaw, and within h^2 of the position.
    yaw = np.append(0.0, np.cumsum(omega[1:] + omega[:-1]) * h / 2)
    velocity = v * np.exp(1j * yaw)
    position = np.append(0.0, np.cumsum(velocity[1:] + velocity[:-1]) * h / 2)
    return np.array([grid, position.real, position.imag, yaw])


def warnings(caplog: pytest.LogCaptureFixture) -> List[str]:
    """What was warned of so far."""
    return [r.getMessage() for r in caplog.records if r.levelno >= logging.WARNING]


def test_the_turtlebot_in_the_office_drives_an_arc(office):
    office.drive(0.5, 0.2)

    for second in range(1, 11):
        office.run(1.0)
        assert office.model("turtlebot").pose == pytest.approx(arc(0.5, 0.2, second), abs=1e-3)


@pytest.mark.parametrize(
    ("linear", "angular"), [(0.3, 0.0), (0.5, 0.4), (-0.3, 0.3), (0.4, -0.5), (0.0, 2.0)]
)
def test_the_last_command_holds_and_leads_along_its_arc(empty_room, linear, angular):
    empty_room.drive(linear, angular)

    truth = empty_room.record(GROUND_TRUTH, 10.0)

    for message in truth[1:]:
        time = message.header.stamp.to_sec()
        x, y, yaw = arc(linear, angular, time)
        assert pose_of(message)[:2] == pytest.approx((x, y), abs=1e-3)
        assert math.remainder(pose_of(message)[2] - yaw, math.tau) == pytest.approx(0.0, abs=1e-3)
        assert twist_of(message) == pytest.approx((linear, 0.0, angular), abs=1e-3)


def test_a_body_turns_about_its_origin_not_about_its_middle(files):
    footprint = "{type: circle, center: [0.7, 0.3], radius: 0.2, density: 10}"
    robot = files.robot(DRIVE, footprint=footprint).drive(0.0, 1.0)

    robot.run(3.0)

    assert robot.model().pose == pytest.approx((0.0, 0.0, 3.0), abs=1e-3)


@pytest.mark.parametrize(
    ("key", "command", "component"),
    [("linear_dynamics", (2.0, 0.0), 0), ("angular_dynamics", (0.0, -2.0), 2)],
)
@pytest.mark.parametrize(
    ("limits", "speed_at"),
    [
        # Commanded for a second, and then to stop.
        pytest.param(
            "{acceleration_limit: 1}",
            lambda t: t if t <= 1 else max(0.0, 2 - t),
            id="acceleration",
        ),
        pytest.param(
            "{acceleration_limit: 1, deceleration_limit: 4}",
            lambda t: t if t <= 1 else max(0.0, 1 - 4 * (t - 1)),
            id="deceleration",
        ),
        pytest.param("{velocity_limit: 0.5}", lambda t: 0.5 if 0 < t <= 1 else 0.0, id="velocity"),
        pytest.param(
            "{acceleration_limit: 2, velocity_limit: 0.5}",
            lambda t: min(0.5, 2 * t) if t <= 1 else max(0.0, 0.5 - 2 * (t - 1)),
            id="all",
        ),
        pytest.param("{}", lambda t: 2.0 if 0 < t <= 1 else 0.0, id="none"),
    ],
)
def test_dynamics_limits_bound_the_velocity(
    files, key: str, command: Tuple[float, float], component: int, limits: str,
    speed_at: Callable[[float], float],
):  # fmt: skip
    robot = files.robot(f"{DRIVE}, {key}: {limits}").drive(*command)
    sign = math.copysign(1.0, sum(command))

    messages = robot.record(GROUND_TRUTH, 1.0)
    robot.drive(0.0, 0.0)
    messages += robot.record(GROUND_TRUTH, 1.5)

    speeds = [sign * twist_of(message)[component] for message in messages]
    expected = [speed_at(message.header.stamp.to_sec()) for message in messages]
    assert speeds == pytest.approx(expected, abs=1e-3)


V_CURVE = {0: 0.0, 2: 1.0, 5: 1.0, 6.25: 0.0}
OMEGA_CURVE = {0: 0.0, 3: 0.9, 5: 0.9, 6.5: 0.0}


@pytest.mark.parametrize(
    ("limits", "commands", "speed", "turn"),
    [
        # Commands (linear, angular) by time; the speed and the yaw rate at their curves' corners.
        pytest.param(
            "linear_dynamics: {acceleration_limit: 0.5, deceleration_limit: 0.8}",
            {0: (1.0, 0.0), 5: (0.0, 0.0)},
            V_CURVE,
            {0: 0.0},
            id="straight",
        ),
        pytest.param(
            "linear_dynamics: {acceleration_limit: 0.5, deceleration_limit: 0.8}",
            {0: (1.0, 0.7), 5: (0.0, 0.7)},
            V_CURVE,
            {0: 0.7},
            id="a speed that changes in a turn",
        ),
        pytest.param(
            "angular_dynamics: {acceleration_limit: 0.3, deceleration_limit: 0.6}",
            {0: (0.8, 0.9), 5: (0.8, 0.0)},
            {0: 0.8},
            OMEGA_CURVE,
            id="clothoids",
        ),
        pytest.param(
            "linear_dynamics: {acceleration_limit: 0.5, deceleration_limit: 0.8}, "
            "angular_dynamics: {acceleration_limit: 0.3, deceleration_limit: 0.6}",
            {0: (1.0, 0.9), 5: (0.0, 0.0)},
            V_CURVE,
            OMEGA_CURVE,
            id="both",
        ),
        pytest.param(
            "linear_dynamics: {acceleration_limit: 0.5, velocity_limit: 0.6}, "
            "angular_dynamics: {acceleration_limit: 0.3, velocity_limit: 0.7}",
            {0: (9.0, -9.0), 5: (0.0, 0.0)},
            {0: 0.0, 1.2: 0.6, 5: 0.6, 6.2: 0.0},
            {0: 0.0, 7 / 3: -0.7, 5: -0.7, 22 / 3: 0.0},
            id="both up to their velocity limits",
        ),
        pytest.param(
            "linear_dynamics: {acceleration_limit: 0.5, deceleration_limit: 0.8}, "
            "angular_dynamics: {acceleration_limit: 0.3, deceleration_limit: 0.6}",
            {0: (1.0, 0.9), 5: (-1.0, -0.9)},
            {**V_CURVE, 8.25: -1.0},
            {**OMEGA_CURVE, 9.5: -0.9},
            id="both reversed",
        ),
    ],
)
@pytest.mark.parametrize("step", [0.005, 0.02])
def test_limited_drives_follow_the_integral_of_their_exact_velocity(
    files, limits: str, commands: Dict[float, Tuple[float, float]], speed: Dict[float, float],
    turn: Dict[float, float], step: float,
):  # fmt: skip
    footprint = "{type: circle, center: [0.2, 0.1], radius: 0.2, density: 10}"
    robot = files.robot(f"{DRIVE}, {limits}", footprint=footprint)
    robot.timekeeper = Timekeeper(step)

    truth: List[Any] = []
    starts = list(commands)
    for start, end in zip(starts, [*starts[1:], 10]):
        robot.drive(*commands[start])
        truth += robot.record(GROUND_TRUTH, end - start)

    times = np.array([message.header.stamp.to_sec() for message in truth])
    grid, x, y, yaw = path_of(speed, turn, 10.0)
    measured = np.array([pose_of(message) for message in truth])
    assert np.abs(measured[:, 0] - np.interp(times, grid, x)).max() < 1e-3
    assert np.abs(measured[:, 1] - np.interp(times, grid, y)).max() < 1e-3
    turned = np.exp(1j * (measured[:, 2] - np.interp(times, grid, yaw)))
    assert np.abs(np.angle(turned)).max() < 1e-3
    twists = np.array([twist_of(message) for message in truth[1:]])  # the first is at rest
    for axis, curve in ((0, speed), (1, {0: 0.0}), (2, turn)):
        expected = np.interp(times[1:], list(curve), list(curve.values()))
        assert np.abs(twists[:, axis] - expected).max() < 1e-3


def test_noise_has_the_configured_variances_about_the_truth(files):
    pose_noise, twist_noise = [0.04, 0.01, 0.0025], [0.09, 0.0004, 0.16]
    robot = files.robot(
        f"{DRIVE}, odom_pose_noise: {pose_noise}, odom_twist_noise: {twist_noise}",
        pose="[3, -2, 1]",
        seed=7,
    )

    messages = robot.record(FILTERED, 10.0)

    noise = np.array([[*pose_of(m), *twist_of(m)] for m in messages]) - [3, -2, 1, 0, 0, 0]
    scaled = noise / np.sqrt([*pose_noise, *twist_noise])
    count = len(scaled)
    assert count == 2000
    # A sum of n squares of standard normals has the mean n and the variance 2 n (chi-squared).
    assert np.abs((scaled**2).sum(axis=0) - count).max() < 4 * math.sqrt(2 * count)
    assert np.abs(scaled.sum(axis=0)).max() < 4 * math.sqrt(count)
    # The components do not know of each other, nor does one message of the one before.
    correlation = scaled.T @ scaled / count - np.diag((scaled**2).mean(axis=0))
    assert np.abs(correlation).max() < 4 / math.sqrt(count)
    assert np.abs((scaled[1:] * scaled[:-1]).mean(axis=0)).max() < 4 / math.sqrt(count)


def test_ground_truth_has_no_noise(files):
    noise = "odom_pose_noise: [1, 1, 1], odom_twist_noise: [1, 1, 1]"
    robot = files.robot(f"{DRIVE}, {noise}", pose="[3, -2, 1]").run()

    truth = robot.last(GROUND_TRUTH)

    assert pose_of(truth) == pytest.approx((3.0, -2.0, 1.0), abs=1e-6)
    assert twist_of(truth) == (0.0, 0.0, 0.0)


def test_the_twist_topic_has_the_noise_of_the_odometry(files):
    robot = files.robot(f"{DRIVE}, odom_twist_noise: [0.1, 0.2, 0.3]").drive(1.0)

    robot.run(0.1)

    assert twist_of(robot.last(TWIST)) == pytest.approx(twist_of(robot.last(FILTERED)), abs=1e-12)
    assert twist_of(robot.last(TWIST)) != twist_of(robot.last(GROUND_TRUTH))


def test_covariances_are_by_default_the_variances_on_the_diagonal(files):
    robot = files.robot(f"{DRIVE}, odom_pose_noise: [1, 2, 3], odom_twist_noise: [4, 5, 6]").run()

    # x, y, z, roll, pitch, yaw
    for topic in (FILTERED, GROUND_TRUTH):
        message = robot.last(topic)
        assert list(message.pose.covariance) == np.diag([1.0, 2, 0, 0, 0, 3]).ravel().tolist()
        assert list(message.twist.covariance) == np.diag([4.0, 5, 0, 0, 0, 6]).ravel().tolist()


def test_given_covariances_are_sent_as_they_are(files):
    pose, twist = [i / 2 for i in range(36)], [i / 4 for i in range(36)]
    given = f"odom_pose_covariance: {pose}, odom_twist_covariance: {twist}"
    robot = files.robot(f"{DRIVE}, odom_pose_noise: [1, 2, 3], {given}").run()

    message = robot.last(FILTERED)

    assert list(message.pose.covariance) == pose
    assert list(message.twist.covariance) == twist


@pytest.mark.parametrize(("local", "expected"), [("true", (1.0, 0.0)), ("false", (0.6, 0.8))])
def test_odometry_gives_its_twist_in_the_local_frame_or_the_worlds(files, local, expected):
    heading = math.atan2(0.8, 0.6)
    drive = f"{DRIVE}, twist_in_local_frame: {local}"
    robot = files.robot(drive, pose=f"[0, 0, {heading}]").drive(1.0).run(0.1)

    for topic in (FILTERED, GROUND_TRUTH):
        assert twist_of(robot.last(topic))[:2] == pytest.approx(expected, abs=1e-4)
    assert twist_of(robot.last(TWIST))[:2] == pytest.approx((1.0, 0.0), abs=1e-4)


@pytest.mark.parametrize(
    ("flag", "topics", "frames"),
    [
        ("", {FILTERED, GROUND_TRUTH, TWIST}, {"base"}),
        (", enable_odom_pub: false", {TWIST}, {"base"}),
        (", enable_twist_pub: false", {FILTERED, GROUND_TRUTH}, {"base"}),
        (", enable_odom_tf_pub: false", {FILTERED, GROUND_TRUTH, TWIST}, set()),
    ],
)
def test_flags_switch_topics_and_the_transform_off(files, flag, topics, frames):
    robot = files.robot(DRIVE + flag).run()

    assert robot.transport.topics == topics
    assert set(robot.transport.transforms) == frames
    assert all(robot.last(topic) is not None for topic in topics)


@pytest.mark.parametrize(
    ("linear", "angular"),
    [(math.nan, 0.0), (0.0, math.nan), (math.inf, 0.0), (0.0, -math.inf)],
)
def test_a_command_that_is_no_velocity_is_ignored_with_a_warning(files, caplog, linear, angular):
    robot = files.robot(DRIVE, namespace="robot1").drive(0.5, topic="/robot1/cmd_vel").run(1.0)

    robot.drive(linear, angular, topic="/robot1/cmd_vel").run(1.0)

    [message] = warnings(caplog)
    assert "robot1/cmd_vel" in message
    assert f"linear.x={linear}" in message
    assert f"angular.z={angular}" in message
    assert robot.model().pose == pytest.approx((1.0, 0.0, 0.0), abs=1e-3)


def test_what_a_differential_drive_cannot_do_is_not_looked_at(files, caplog):
    robot = files.robot(DRIVE)
    twist = Twist()
    twist.linear.x, twist.linear.y, twist.angular.x = 0.5, math.nan, math.inf

    robot.transport.send("/cmd_vel", twist)
    robot.run(1.0)

    assert warnings(caplog) == []
    assert robot.model().pose == pytest.approx((0.5, 0.0, 0.0), abs=1e-3)


def test_the_drive_stops_when_it_ends_before_its_body(files):
    robot = files.robot(f"{DRIVE}, linear_dynamics: {{deceleration_limit: 1}}").drive(0.5)
    robot.run(1.0)

    robot.world.close()
    robot.run(5.0)

    # It rolls out over v^2 / 2a.
    assert robot.model().pose == pytest.approx((0.5 + 0.125, 0.0, 0.0), abs=1e-3)


def test_a_drive_ends_in_peace_after_its_body(files, caplog):
    robot = files.robot(DRIVE).drive(0.5).run(1.0)

    robot.model().base.physics_body.remove()
    robot.world.close()

    assert warnings(caplog) == []


@pytest.mark.parametrize(("linear", "angular"), [(1e39, 0.0), (0.0, 1e300), (-1e300, 1.0)])
def test_a_command_beyond_single_precision_does_not_stall_the_robot(files, linear, angular):
    robot = files.robot(DRIVE).drive(linear, angular).run(0.1)

    robot.world.move_model("robot", robot.model().pose._replace(x=0.0, y=0.0, yaw=0.0))
    robot.drive(1.0).run(1.0)

    assert robot.model().pose == pytest.approx((1.0, 0.0, 0.0), abs=1e-2)


def test_the_transform_is_the_filtered_odometry(files):
    robot = files.robot(f"{DRIVE}, odom_pose_noise: [1, 1, 1]", pose="[3, -2, 1]").drive(1.0, 1.0)

    robot.run(0.5)

    odometry, transform = robot.last(FILTERED), robot.transport.transforms["base"]
    assert tuple(transform.pose) == pytest.approx(pose_of(odometry), abs=1e-9)
    assert (transform.parent, transform.roll) == (odometry.header.frame_id, 0.0)
    assert transform.nanoseconds == odometry.header.stamp.to_nsec()


@pytest.mark.parametrize(
    ("rate", "period"), [("", 5_000_000), (", pub_rate: inf", 5_000_000), (", pub_rate: 50", 2e7)]
)
def test_odometry_comes_at_its_rate_stamped_with_simulated_time(files, rate, period):
    robot = files.robot(DRIVE + rate)

    messages = robot.record(FILTERED, 1.0)

    stamps = [message.header.stamp.to_nsec() for message in messages]
    assert stamps == [round(i * period) for i in range(round(1e9 / period))]


def test_all_that_is_published_together_has_one_stamp(files):
    robot = files.robot(f"{DRIVE}, pub_rate: 30").run(0.99)

    stamps = {robot.last(topic).header.stamp.to_nsec() for topic in (FILTERED, GROUND_TRUTH, TWIST)}

    assert stamps == {robot.transport.transforms["base"].nanoseconds}


def test_frames_and_topics_are_the_documented_ones(files):
    robot = files.robot(DRIVE).run()

    filtered, truth, twist = (robot.last(topic) for topic in (FILTERED, GROUND_TRUTH, TWIST))
    assert (filtered.header.frame_id, filtered.child_frame_id) == ("odom", "base")
    assert (truth.header.frame_id, truth.child_frame_id) == ("map", "base")
    assert twist.header.frame_id == "base"
    assert robot.transport.subscribed == {"/cmd_vel"}


def test_frames_and_topics_can_be_named(files):
    robot = files.robot(
        f"{DRIVE}, twist_sub: go, odom_pub: a, ground_truth_pub: b, twist_pub: c, "
        "odom_frame_id: start, ground_truth_frame_id: world"
    ).run()

    assert robot.transport.subscribed == {"/go"}
    assert robot.transport.topics == {"/a", "/b", "/c"}
    assert robot.last("/a").header.frame_id == "start"
    assert robot.last("/b").header.frame_id == "world"
    assert robot.transport.transforms["base"].parent == "start"


def test_a_namespace_is_put_before_topics_and_the_models_own_frames(files):
    robot = files.robot(DRIVE, namespace="robot1").drive(1.0, topic="/robot1/cmd_vel").run(1.0)

    assert robot.transport.topics == {f"/robot1{t}" for t in (FILTERED, GROUND_TRUTH, TWIST)}
    odometry = robot.last(f"/robot1{FILTERED}")
    assert (odometry.header.frame_id, odometry.child_frame_id) == ("odom", "robot1_base")
    assert robot.transport.transforms["robot1_base"].parent == "odom"
    assert robot.model().pose.x == pytest.approx(1.0, abs=1e-3)


def test_an_absolute_topic_is_outside_of_the_namespace(files):
    robot = files.robot(f"{DRIVE}, twist_sub: /cmd_vel, twist_pub: /twist", namespace="robot1")

    robot.drive(1.0, topic="/cmd_vel").run(1.0)

    assert robot.transport.subscribed == {"/cmd_vel"}
    assert "/twist" in robot.transport.topics
    assert robot.model().pose.x == pytest.approx(1.0, abs=1e-3)


def test_nothing_is_published_that_nobody_listens_to(files, deaf_transport):
    files.robot(DRIVE, transport=deaf_transport).drive(1.0).run(0.1)

    assert deaf_transport.published == []
    assert deaf_transport.transforms == {}


@pytest.mark.parametrize(
    ("drive", "message"),
    [
        pytest.param(
            "type: DiffDrive, name: drive",
            'plugins[0] "drive": the required key "body" is missing',
            id="body missing",
        ),
        pytest.param(
            "type: DiffDrive, name: drive, body: bas",
            'plugins[0].body: the model has no body "bas" (did you mean "base"?); it has: base',
            id="unknown body",
        ),
        pytest.param(
            f"{DRIVE}, linear_dynamics: {{acceleration_limt: 1}}",
            'plugins[0].linear_dynamics: unknown key "acceleration_limt" '
            '(did you mean "acceleration_limit"?)',
            id="unknown limit",
        ),
        pytest.param(
            f"{DRIVE}, angular_dynamics: {{velocity_limit: -1}}",
            "plugins[0].angular_dynamics.velocity_limit: expected a number of 0 or more, found -1",
            id="negative limit",
        ),
        pytest.param(
            f"{DRIVE}, angular_dynamic: {{velocity_limit: 1}}",
            'plugins[0] "drive": unknown key "angular_dynamic" (did you mean "angular_dynamics"?)',
            id="unknown key",
        ),
        pytest.param(
            f"{DRIVE}, pub_rate: 0",
            "plugins[0].pub_rate: expected a number above 0, found 0",
            id="rate of zero",
        ),
        pytest.param(
            f"{DRIVE}, odom_pose_noise: [0, 0, -1]",
            "plugins[0].odom_pose_noise: expected a list of 3 numbers of 0 or more, "
            "found [0, 0, -1]",
            id="negative variance",
        ),
        pytest.param(
            f"{DRIVE}, odom_twist_covariance: [1, 2, 3]",
            "plugins[0].odom_twist_covariance: expected a list of 36 numbers, found [1, 2, 3]",
            id="short covariance",
        ),
        pytest.param(
            f"{DRIVE}, enable_odom_pub: perhaps",
            'plugins[0].enable_odom_pub: expected true or false, found "perhaps"',
            id="no flag",
        ),
    ],
)
def test_a_wrong_configuration_is_refused_at_its_line(files, drive, message):
    assert files.refusal(drive) == f"robot.model.yaml:5: {message}"
