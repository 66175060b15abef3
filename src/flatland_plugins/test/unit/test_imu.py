"""Imu: its readings against kinematics, its noise against the configured variances."""

import math
from typing import Any, List, Tuple

import numpy as np
import pytest
from readings import assert_white

from flatland_server.geometry import Pose

IMU = "type: Imu, name: imu_sensor, body: base"
DRIVE = "type: DiffDrive, name: drive, body: base"
FILTERED, GROUND_TRUTH = "/imu/filtered", "/imu/ground_truth"
GRAVITY = 9.80665

STEP = 5_000_000  # ns


def xyz(vector: Any) -> Tuple[float, float, float]:
    return vector.x, vector.y, vector.z


def acceleration_of(message: Any) -> Tuple[float, float, float]:
    return xyz(message.linear_acceleration)


def angular_velocity_of(message: Any) -> Tuple[float, float, float]:
    return xyz(message.angular_velocity)


def angles_of(message: Any) -> Tuple[float, float, float]:
    """Roll, pitch and yaw of the orientation, from its rotation matrix."""
    x, y, z, w = (getattr(message.orientation, axis) for axis in "xyzw")
    assert x * x + y * y + z * z + w * w == pytest.approx(1.0, abs=1e-12)
    matrix_x = (1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w))
    roll = math.atan2(2 * (y * z + x * w), 1 - 2 * (x * x + y * y))
    return roll, math.asin(-matrix_x[2]), math.atan2(matrix_x[1], matrix_x[0])


def stamps_of(messages: List[Any]) -> List[int]:
    return [message.header.stamp.to_nsec() for message in messages]


def closely(forwards: float, left: float, up: float = GRAVITY) -> Any:
    """An approximate acceleration, within a thousandth of its size in the plane."""
    return pytest.approx((forwards, left, up), abs=1e-3 * math.hypot(forwards, left))


@pytest.mark.parametrize(("key", "up"), [("", GRAVITY), (", gravity: 0", 0), (", gravity: 2", 2)])
def test_at_rest_it_reads_gravity_alone(files, key, up):
    robot = files.robot(f"{IMU}{key}", pose="[3, -2, 1]").run(0.1)

    for message in (robot.last(GROUND_TRUTH), robot.last(FILTERED)):
        assert measured(message) == pytest.approx([0, 0, 1, 0, 0, 0, 0, 0, up], abs=1e-6)


@pytest.mark.parametrize("rate", ["pub_rate: inf", "update_rate: 30"])  # one key
@pytest.mark.parametrize(("speed", "omega"), [(0.5, 0.25), (2.0, -0.5), (-0.5, 0.4), (-1.0, -1.0)])
def test_on_a_circle_it_reads_v_squared_over_r_inwards(files, speed, omega, rate):
    robot = files.robot(f"{IMU}, {rate}", DRIVE, pose="[3, -2, 1]").drive(speed, omega)
    robot.run(0.1)

    messages = robot.record(GROUND_TRUTH, 2.0)

    assert len(messages) == (400 if "inf" in rate else 60)
    # The centre is to the left if the speed and the turn have one sign.
    inwards = math.copysign(speed**2 / abs(speed / omega), speed * omega)
    for message in messages:
        assert acceleration_of(message) == closely(0.0, inwards)
        assert angular_velocity_of(message) == pytest.approx((0.0, 0.0, omega), rel=1e-6)


def test_along_a_straight_line_it_reads_the_drives_acceleration(files):
    limits = "linear_dynamics: {acceleration_limit: 1.5, deceleration_limit: 4}"
    robot = files.robot(IMU, f"{DRIVE}, {limits}", pose="[3, -2, 1]").drive(2.0)

    speeding_up = robot.record(GROUND_TRUTH, 1.0)
    robot.run(1.0)
    steady = robot.record(GROUND_TRUTH, 0.5)
    robot.drive(0.0)
    braking = robot.record(GROUND_TRUTH, 0.4)

    assert len(speeding_up) == 200
    assert all(acceleration_of(message) == closely(1.5, 0.0) for message in speeding_up)
    for message in steady:
        assert acceleration_of(message) == pytest.approx((0.0, 0.0, GRAVITY), abs=1e-4)
    assert all(acceleration_of(message) == closely(-4.0, 0.0) for message in braking)


def test_off_centre_spin_reads_the_acceleration_of_the_origin(files):
    robot = files.robot(IMU, footprint="{type: circle, center: [0.5, 0], radius: 0.2, density: 10}")
    # About its middle, half a metre before the origin, which therefore goes backwards around it.
    robot.model().base.physics_body.velocity = (0.0, -0.5 * 3.0, 3.0)

    for message in robot.record(GROUND_TRUTH, 2.0):
        assert acceleration_of(message) == closely(0.5 * 3.0**2, 0.0)
        assert angular_velocity_of(message) == pytest.approx((0.0, 0.0, 3.0))


@pytest.mark.parametrize(
    ("steps", "rate", "jolt"),
    [
        (0, "inf", 220.0),
        (3, "inf", 220.0),
        (0, "50", 220.0),  # the first message is about the first step alone
        (1, "50", 55.0),
        (4, "50", 55.0),
        (5, "50", 55.0),
        (1, "30", 1.1 / 0.035),
    ],
)
def test_a_jolt_is_spread_over_the_time_between_two_messages(files, steps, rate, jolt):
    robot = files.robot(f"{IMU}, pub_rate: {rate}", DRIVE)
    robot.run(0.005 * steps)

    messages = robot.drive(1.1).record(GROUND_TRUTH, 0.12)

    readings = [acceleration_of(message)[0] for message in messages[:3]]
    assert readings == pytest.approx([jolt, 0.0, 0.0], abs=1e-3)


@pytest.mark.parametrize("rate", ["inf", "50", "30", "7"])
def test_accelerations_add_up_to_the_velocity(files, rate):
    limits = "linear_dynamics: {acceleration_limit: 3, deceleration_limit: 40}"
    robot = files.robot(f"{IMU}, pub_rate: {rate}", f"{DRIVE}, {limits}")

    messages, truth = [], {}
    for speed in (1.1, -0.7, 0.3, 0.0, 2.0):
        robot.drive(speed)
        for _ in range(100):
            messages += robot.record(GROUND_TRUTH, 0.005)
            truth[robot.timekeeper.nanoseconds] = robot.model().base.physics_body.velocity[0]

    velocity = 0.0
    for stamp, before, message in zip(stamps_of(messages), [0, *stamps_of(messages)], messages):
        velocity += acceleration_of(message)[0] * (stamp - before) * 1e-9
        assert velocity == pytest.approx(truth[stamp], abs=1e-4)
    assert len(messages) > 15


@pytest.mark.parametrize("rate", ["inf", "50", "7"])
def test_a_new_subscriber_gets_no_acceleration_of_the_past(files, no_subscribers, rate):
    robot = files.robot(f"{IMU}, pub_rate: {rate}", DRIVE, transport=no_subscribers)
    no_subscribers.set_subscribed_topics([GROUND_TRUTH])
    robot.run(0.3)
    no_subscribers.set_subscribed_topics([])
    robot.drive(2.0).run(60.0)

    no_subscribers.set_subscribed_topics([GROUND_TRUTH])
    messages = robot.record(GROUND_TRUTH, 0.5)

    assert robot.last(FILTERED) is None
    assert len(messages) >= 3
    for message in messages:
        assert acceleration_of(message) == pytest.approx((0.0, 0.0, GRAVITY), abs=1e-3)


@pytest.mark.parametrize(("rate", "steps"), [("inf", 0), (50, 1), (50, 2), (50, 3), (50, 4)])
def test_a_move_is_no_jolt(files, rate, steps):
    """Also between two messages."""
    limits = "linear_dynamics: {acceleration_limit: 0.5}"
    robot = files.robot(f"{IMU}, pub_rate: {rate}", f"{DRIVE}, {limits}").drive(2.0)
    robot.run(4.0 + 0.005 * steps)

    robot.world.move_model("robot", Pose(5.0, 5.0, 2.0))
    messages = robot.record(GROUND_TRUTH, 0.2)

    assert len(messages) == (10 if rate == 50 else 40)
    for message in messages:
        assert measured(message) == pytest.approx([0, 0, 2, 0, 0, 0, 0, 0, GRAVITY], abs=1e-6)


def test_the_orientation_is_that_at_the_stamp(files):
    robot = files.robot(IMU, DRIVE).drive(0.0, 1.0)

    messages = robot.record(GROUND_TRUTH, 2.0)

    assert stamps_of(messages) == [STEP * (i + 1) for i in range(400)]
    for message in messages:
        time = message.header.stamp.to_sec()
        assert angles_of(message) == pytest.approx((0.0, 0.0, time), abs=1e-4)


NOISY = (
    f"{IMU}, orientation_noise: [0.01, 0.0025, 0.04], angular_velocity_noise: [0.09, 0.0004, 4], "
    "linear_acceleration_noise: [0.16, 25, 0.000001]"
)
VARIANCES = [0.01, 0.0025, 0.04, 0.09, 0.0004, 4, 0.16, 25, 0.000001]


def measured(message: Any) -> List[float]:
    return [*angles_of(message), *angular_velocity_of(message), *acceleration_of(message)]


def covariances(message: Any) -> List[List[float]]:
    names = ("orientation", "angular_velocity", "linear_acceleration")
    return [list(getattr(message, f"{name}_covariance")) for name in names]


def test_noise_has_the_configured_variances_about_the_truth(files):
    robot = files.robot(NOISY, pose="[3, -2, 1]", seed=7)

    messages = robot.record(FILTERED, 10.0)

    at_rest = [0, 0, 1, 0, 0, 0, 0, 0, GRAVITY]
    assert len(messages) == 2000
    assert_white(np.array([measured(message) for message in messages]) - at_rest, VARIANCES)
    truth = robot.last(GROUND_TRUTH)
    assert measured(truth) == pytest.approx(at_rest, abs=1e-6)
    for message in (truth, messages[-1]):
        for found, variances in zip(covariances(message), np.reshape(VARIANCES, (3, 3))):
            assert found == np.diag(variances).ravel().tolist()


def test_noise_depends_on_the_seed_and_the_time_alone(files):
    often = files.robot(NOISY, seed=3).record(FILTERED, 0.5)
    seldom = files.robot(f"{NOISY}, pub_rate: 10", seed=3).record(FILTERED, 0.5)
    other = files.robot(NOISY, seed=4).record(FILTERED, 0.5)

    readings = dict(zip(stamps_of(often), map(measured, often)))
    assert [measured(m) for m in seldom] == [readings[stamp] for stamp in stamps_of(seldom)]
    assert len(seldom) == 5
    assert not any(measured(m) == readings[m.header.stamp.to_nsec()] for m in other)


def test_given_covariances_are_sent_as_they_are(files):
    given = [[i / factor for i in range(-1, 8)] for factor in (2, 4, 8)]
    robot = files.robot(
        f"{NOISY}, orientation_covariance: {given[0]}, angular_velocity_covariance: {given[1]}, "
        f"linear_acceleration_covariance: {given[2]}"
    ).run()

    assert covariances(robot.last(FILTERED)) == covariances(robot.last(GROUND_TRUTH)) == given


def test_the_bodys_own_frame_is_not_made_its_own_parent(files):
    robot = files.robot(f"{IMU}, imu_frame_id: base", namespace="robot1").run()

    assert robot.transport.transforms == {}
    assert robot.last("/robot1/imu/filtered").header.frame_id == "robot1_base"


def test_both_topics_can_be_switched_off(files):
    robot = files.robot(f"{IMU}, enable_imu_pub: false").run()

    assert (robot.transport.topics, set(robot.transport.transforms)) == (set(), {"imu"})


class SubscribingPhysics:
    """A physical world; a topic gets a subscriber in the middle of its step."""

    def __init__(self, physics: Any, transport: Any) -> None:
        self._physics = physics
        self._transport = transport

    def step(self, dt: float) -> None:
        self.step_until_contact(dt, 1)

    def step_until_contact(self, dt: float, count: int) -> None:
        self._physics.step_until_contact(dt, count)
        self._transport.set_subscribed_topics([GROUND_TRUTH])


def test_a_subscriber_back_during_a_step_gets_the_next_message(files, no_subscribers):
    robot = files.robot(IMU, DRIVE, transport=no_subscribers).drive(2.0, 2.0).run(1.0)
    no_subscribers.set_subscribed_topics([GROUND_TRUTH])
    earlier = robot.run().last(GROUND_TRUTH)
    no_subscribers.set_subscribed_topics([])
    robot.run(0.5)
    contents = robot.world.contents
    contents.physics = SubscribingPhysics(contents.physics, no_subscribers)

    in_the_middle = robot.run().last(GROUND_TRUTH)
    afterwards = robot.run().last(GROUND_TRUTH)

    assert in_the_middle is earlier
    assert acceleration_of(afterwards) == closely(0.0, 4.0)
