"""TricycleDrive: motion about the turning centre, steering within limits, geometry, odometry."""

import logging
import math
from typing import Any, Dict, List, Tuple

import numpy as np
import pytest
from geometry_msgs.msg import Twist

from flatland_server.exceptions import FlatlandError
from flatland_server.geometry import Pose
from flatland_server.timekeeper import Timekeeper

FILTERED, GROUND_TRUTH, TWIST = "/odometry/filtered", "/odometry/ground_truth", "/twist"
WHEELBASE, HALF_TRACK = 1.1, 0.35

# A small forklift: a body of 280 kg and wheels of 5 kg.
BODY_SHAPE = "[[0.2, -0.4], [0.2, 0.4], [-1.2, 0.4], [-1.2, -0.4]]"
WHEEL_SHAPE = "[[-0.1, -0.03], [0.1, -0.03], [0.1, 0.03], [-0.1, 0.03]]"
WHEEL = f"footprints: [{{type: polygon, points: {WHEEL_SHAPE}, density: 400}}]"

MODEL = """
bodies:
  - {{name: base, footprints: [{{type: polygon, points: {body_shape}, density: 250}}]}}
  - {{name: front_wheel, {wheel}}}
  - {{name: left_wheel, pose: [{left_x}, {left_y}, 0], {wheel}}}
  - {{name: right_wheel, pose: [{right_x}, {right_y}, 0], {wheel}}}
  - {{name: hub_cap, pose: [{left_x}, {left_y}, 0],
     footprints: [{{type: circle, radius: 0.05, density: 10, layers: []}}]}}
joints:
  - {{type: revolute, name: front, {front}}}
  - {{type: weld, name: left, bodies: [{{name: left_wheel, anchor: [0, 0]}},
      {{name: base, anchor: [{left_x}, {left_y}]}}]}}
  - {{type: weld, name: right, bodies: [{{name: base, anchor: [{right_x}, {right_y}]}},
      {{name: right_wheel, anchor: [0, 0]}}]}}
  - {{type: revolute, name: hub, bodies: [{{name: left_wheel, anchor: [0, 0]}},
      {{name: hub_cap, anchor: [0, 0]}}]}}
plugins:
  - type: TricycleDrive
    name: drive
    body: base
    front_wheel_joint: front
    rear_left_wheel_joint: left
    rear_right_wheel_joint: right
    {keys}
"""
FIRST_LINE = MODEL[: MODEL.index("{keys}")].count("\n")
"""The line of the file that the keys of a test begin in."""
FRONT = "bodies: [{name: front_wheel, anchor: [0, 0]}, {name: base, anchor: [0, 0]}]"
FRONT_REVERSED = "bodies: [{name: base, anchor: [0, 0]}, {name: front_wheel, anchor: [0, 0]}]"
either_way_round = pytest.mark.parametrize(
    "front", [FRONT, FRONT_REVERSED], ids=["wheel first", "body first"]
)


def forklift(
    files,
    *keys: str,
    left: Tuple[float, float] = (-WHEELBASE, HALF_TRACK),
    right: Tuple[float, float] = (-WHEELBASE, -HALF_TRACK),
    front: str = FRONT,
    entry: str = "",
    replaced: Tuple[str, str] = ("", ""),
    **options: Any,
):
    """A world with a forklift whose drive has these keys too; something in its file replaced."""
    text = MODEL.lstrip("\n").format(
        body_shape=BODY_SHAPE, wheel=WHEEL, front=front, keys="\n    ".join(keys),
        left_x=left[0], left_y=left[1], right_x=right[0], right_y=right[1],
    )  # fmt: skip
    assert replaced[0] in text
    files.write("robot.model.yaml", text.replace(*replaced))
    return files.load({"robot": f"model: robot.model.yaml{entry}"}, **options)


def steer_angle(robot) -> float:
    """Of the front wheel as it is seen, to the body [rad]."""
    wheel, base = (robot.model().get_body(name).pose.yaw for name in ("front_wheel", "base"))
    return math.remainder(wheel - base, math.tau)


def pose_of(odometry: Any) -> Tuple[float, float, float]:
    position, q = odometry.pose.pose.position, odometry.pose.pose.orientation
    return position.x, position.y, 2.0 * math.atan2(q.z, q.w)


def twist_of(stamped: Any) -> Tuple[float, float, float]:
    """The velocity in an Odometry or a TwistStamped."""
    twist = getattr(stamped.twist, "twist", stamped.twist)
    return twist.linear.x, twist.linear.y, twist.angular.z


def twist_at(speed: float, angle: float, wheelbase: float = WHEELBASE) -> Tuple[float, ...]:
    """The velocity of the body at the front wheel, such that the rear axle does not slip.

    The front wheel goes where it points, (v cos a, v sin a); the axle, L behind it, has the lateral
    velocity v sin a - L omega, which is zero.
    """
    across = speed * math.sin(angle)
    return speed * math.cos(angle), across, across / wheelbase


def warnings(caplog: pytest.LogCaptureFixture) -> List[str]:
    """What was warned of so far."""
    return [r.getMessage() for r in caplog.records if r.levelno >= logging.WARNING]


# Without limits


@pytest.mark.parametrize(
    ("speed", "angle"),
    [
        (0.5, 0.3),
        (1.5, -0.7),
        (-0.8, 0.5),
        (2.0, 1.2),
        (0.7, math.pi / 2),
        (0.6, -2.0),
        (1.0, 1e-3),
    ],
)
@either_way_round
def test_the_front_wheel_and_the_rear_axle_follow_circles_about_one_centre(
    files, speed: float, angle: float, front: str
):
    robot = forklift(files, front=front).drive(speed, angle)

    truth = robot.record(GROUND_TRUTH, 10.005)

    # The centre is where the wheels' axles meet, beside the rear axle by L / tan a.
    centre = complex(-WHEELBASE, WHEELBASE / math.tan(angle))
    yaw_rate = speed * math.sin(angle) / WHEELBASE
    assert truth[-1].header.stamp.to_sec() == 10.0
    for message in truth:
        x, y, yaw = pose_of(message)
        turned = np.exp(1j * yaw_rate * message.header.stamp.to_sec())
        wheel = centre + (0 - centre) * turned
        axle = centre + (-WHEELBASE - centre) * turned
        assert (x, y) == pytest.approx((wheel.real, wheel.imag), abs=1e-3)
        behind = Pose(x, y, yaw).apply(-WHEELBASE, 0.0)
        assert behind == pytest.approx((axle.real, axle.imag), abs=1e-3)
        assert math.remainder(yaw - np.angle(turned), math.tau) == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize("speed", [0.5, -1.5])
def test_steered_straight_it_goes_straight_on(files, speed):
    robot = forklift(files).drive(speed, 0.0).run(10.0)

    assert robot.model().pose == pytest.approx((10.0 * speed, 0.0, 0.0), abs=1e-3)


def test_the_rear_wheels_stay_where_they_are_welded(files):
    robot = forklift(files).drive(1.5, 0.6)

    for _ in range(100):
        base = robot.run(0.1).model().pose
        for name, side in (("left_wheel", HALF_TRACK), ("right_wheel", -HALF_TRACK)):
            wheel = robot.model().get_body(name).pose
            assert wheel[:2] == pytest.approx(base.apply(-WHEELBASE, side), abs=1e-3)
            assert math.remainder(wheel.yaw - base.yaw, math.tau) == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize("ahead", [0.0, 0.5, math.pi / 2, math.pi])
def test_ahead_is_from_the_rear_axle_to_the_front_wheel(files, ahead):
    behind = Pose(0.0, 0.0, ahead)
    robot = forklift(
        files,
        left=behind.apply(-WHEELBASE, HALF_TRACK),
        right=behind.apply(-WHEELBASE, -HALF_TRACK),
    ).drive(1.0, 0.4)

    robot.run(0.5)

    omega = math.sin(0.4) / WHEELBASE
    assert robot.model().pose.yaw == pytest.approx(0.5 * omega, abs=1e-3)
    # The chord of an arc is its length by the sinc of half the turn, in the middle direction.
    half_turn = 0.25 * omega
    chord = 0.5 * math.sin(half_turn) / half_turn
    direction = ahead + 0.4 + half_turn
    expected = chord * math.cos(direction), chord * math.sin(direction)
    assert robot.model().pose[:2] == pytest.approx(expected, abs=1e-3)
    assert steer_angle(robot) == pytest.approx(math.remainder(ahead + 0.4, math.tau), abs=1e-3)


@either_way_round
@pytest.mark.parametrize("heading", [0.0, 2.5])
def test_the_front_wheels_body_is_turned_by_the_steering_angle(files, front, heading):
    robot = forklift(files, front=front, entry=f", pose: [2, 3, {heading}]")
    for speed, angle in ((0.0, 0.5), (1.0, 0.5), (1.0, -0.8), (0.0, 0.0)):
        robot.drive(speed, angle).run(0.5)

        assert steer_angle(robot) == pytest.approx(angle, abs=1e-3)
        wheel, base = (robot.model().get_body(name).pose for name in ("front_wheel", "base"))
        assert wheel[:2] == pytest.approx(base[:2], abs=1e-3)


@pytest.mark.parametrize(
    ("front", "angle", "seen"),
    [
        # The joint's limits are of the second body's angle less the first one's.
        (FRONT, 0.6, 0.2),
        (FRONT, -0.6, -0.1),
        (FRONT_REVERSED, 0.6, 0.1),
        (FRONT_REVERSED, -0.6, -0.2),
    ],
)
def test_how_far_the_front_wheels_joint_turns_is_only_a_matter_of_what_is_seen(
    files, front: str, angle: float, seen: float
):
    robot = forklift(files, front=f"{front}, limits: [-0.2, 0.1]").drive(1.0, angle).run(10.0)

    assert steer_angle(robot) == pytest.approx(seen, abs=1e-3)
    centre = complex(-WHEELBASE, WHEELBASE / math.tan(angle))
    wheel = centre - centre * np.exp(10j * math.sin(angle) / WHEELBASE)
    assert robot.model().pose[:2] == pytest.approx((wheel.real, wheel.imag), abs=1e-3)


def test_standing_it_steers_on_the_spot(files):
    robot = forklift(files).drive(0.0, 0.7).run(1.0)

    assert steer_angle(robot) == pytest.approx(0.7, abs=1e-3)
    assert robot.model().pose == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(("asked", "steered"), [(0.3, 0.3), (0.5, 0.5), (0.9, 0.5), (9.0, 0.5)])
def test_it_steers_no_further_than_the_largest_angle(files, sign, asked, steered):
    robot = forklift(files, "max_steer_angle: 0.5").drive(1.0, sign * asked).run(0.1)

    assert steer_angle(robot) == pytest.approx(sign * steered, abs=1e-3)
    expected = twist_at(1.0, sign * steered)
    assert twist_of(robot.last(GROUND_TRUTH)) == pytest.approx(expected, abs=1e-3)


# Within limits

LINEAR = "linear_dynamics: {acceleration_limit: 0.5, deceleration_limit: 0.8}"
# 0.6 rad: 0.25 rad up to the largest rate, 0.225 along, 0.125 down; back -1 rad: 0.625 along.
STEERING = "angular_dynamics: {acceleration_limit: 0.5, deceleration_limit: 1, velocity_limit: 0.5}"
# Up to 0.3 rad/s in a second, 0.15 rad; down in 0.6 s, 0.09 rad: a triangle without a tip cut off.
TRIANGLE = "angular_dynamics: {acceleration_limit: 0.3, deceleration_limit: 0.5}"

Curve = Dict[float, float]


def at(curve: Curve, times: np.ndarray) -> np.ndarray:
    """A value that changes evenly between the given times. Two times next to each other: a jump."""
    return np.interp(times, list(curve), list(curve.values()))


def path_of(speed: Curve, rate: Curve, duration: float) -> Dict[str, np.ndarray]:
    """Where a front wheel's speed and the rate of its angle lead, by midpoints of 0.1 ms."""
    time, h = np.linspace(0.0, duration, round(duration * 10_000) + 1, retstep=True)
    middle = time[:-1] + h / 2

    def integral(at_middles: np.ndarray) -> np.ndarray:
        return np.append(0.0, np.cumsum(at_middles) * h)

    def halfway(values: np.ndarray) -> np.ndarray:
        return (values[1:] + values[:-1]) / 2

    v = at(speed, middle)
    steer = integral(at(rate, middle))
    yaw = integral(v * np.sin(halfway(steer)) / WHEELBASE)
    place = integral(v * np.exp(1j * halfway(yaw + steer)))
    return {"time": time, "x": place.real, "y": place.imag, "yaw": yaw, "steer": steer}


COURSES = [
    # Commands (speed, angle) by time; the speed and the steering rate at their curves' corners.
    pytest.param(
        (LINEAR,),
        {0: (1.0, 0.0), 5: (0.0, 0.0)},
        {0: 0.0, 2: 1.0, 5: 1.0, 6.25: 0.0},
        {0: 0.0},
        id="straight",
    ),
    pytest.param(
        (STEERING, LINEAR),
        {0: (1.0, 0.6), 4: (1.0, -0.4), 8: (0.0, -0.4)},
        {0: 0.0, 2: 1.0, 8: 1.0, 9.25: 0.0},
        {0: 0, 1: 0.5, 1.45: 0.5, 1.95: 0, 4: 0, 5: -0.5, 6.25: -0.5, 6.75: 0},
        id="trapezoids",
    ),
    pytest.param(
        (TRIANGLE, LINEAR),
        {0: (1.0, 0.24), 5: (-1.0, 0.0)},
        {0: 0.0, 2: 1.0, 5: 1.0, 6.25: 0.0, 8.25: -1.0},
        {0: 0, 1: 0.3, 1.6: 0, 5: 0, 6: -0.3, 6.6: 0},
        id="triangles, and the speed reversed",
    ),
    pytest.param(
        # After 1.5 s it is at 0.5 rad, and stops at 0.625; then it goes back to -0.375.
        (STEERING, LINEAR),
        {0: (1.0, 0.9), 1.5: (1.0, -0.375)},
        {0: 0.0, 2: 1.0},
        {0: 0, 1: 0.5, 1.5: 0.5, 2.0: 0, 3.0: -0.5, 4.25: -0.5, 4.75: 0},
        id="turned round on the way",
    ),
    pytest.param(
        # Told after 1.4 s, at 0.45 rad, to stop at 0.5: it needs 0.125 rad, and comes back from
        # 0.575 by 0.075 in a triangle, p^2 = 2 * 0.075 / (1 / 0.5 + 1 / 1).
        (STEERING,),
        {0: (0.8, 0.9), 1.4: (0.8, 0.5)},
        {0: 0.8},
        {
            0: 0,
            1: 0.5,
            1.4: 0.5,
            1.9: 0,
            1.9 + math.sqrt(0.05) / 0.5: -math.sqrt(0.05),
            1.9 + math.sqrt(0.05) * 3: 0,
        },
        id="told too late",
    ),
    pytest.param(
        ("angular_dynamics: {velocity_limit: 0.25}",),
        {0: (0.8, 0.5), 5: (0.8, -0.5)},
        {0: 0.8},
        {0: 0.25, 2: 0.25, 2 + 1e-9: 0, 5: 0, 5 + 1e-9: -0.25, 9: -0.25, 9 + 1e-9: 0},
        id="rate alone",
    ),
    pytest.param(
        ("angular_dynamics: {acceleration_limit: 0.25}", "max_steer_angle: 0.36"),
        {0: (0.8, 3.0)},
        {0: 0.8},
        {0: 0, 1.2: 0.3, 2.4: 0},  # the deceleration is the acceleration if it is not given
        id="acceleration alone, to the largest angle",
    ),
    pytest.param(
        (
            "angular_dynamics: {acceleration_limit: 0.5, velocity_limit: 0.4}",
            "linear_dynamics: {acceleration_limit: 0.5, velocity_limit: 0.7}",
        ),
        {0: (-9.0, -0.72), 6: (0.0, 0.0)},
        {0: 0.0, 1.4: -0.7, 6: -0.7, 7.4: 0.0},
        {0: 0, 0.8: -0.4, 1.8: -0.4, 2.6: 0, 6: 0, 6.8: 0.4, 7.8: 0.4, 8.6: 0},
        id="backwards, up to the velocity limits",
    ),
]


@pytest.mark.parametrize(("limits", "commands", "speed", "rate"), COURSES)
@pytest.mark.parametrize("step", [0.005, 0.02])
def test_within_limits_it_follows_the_integral_of_its_exact_speed_and_steering(
    files, limits: Tuple[str, ...], commands: Dict[float, Tuple[float, float]], speed: Curve,
    rate: Curve, step: float,
):  # fmt: skip
    robot = forklift(files, *limits)
    robot.timekeeper = Timekeeper(step)

    truth: List[Any] = []
    steered: List[float] = []
    starts = list(commands)
    for start, end in zip(starts, [*starts[1:], 10]):
        robot.drive(*commands[start])
        for _ in range(round((end - start) / step)):
            steered.append(steer_angle(robot))
            truth.append(robot.run().last(GROUND_TRUTH))

    path = path_of(speed, rate, 10.0)
    times = np.array([message.header.stamp.to_sec() for message in truth])
    x, y, yaw, steer = (np.interp(times, path["time"], path[k]) for k in ("x", "y", "yaw", "steer"))
    measured = np.array([pose_of(message) for message in truth])
    assert np.abs(measured[:, 0] - x).max() < 1e-3
    assert np.abs(measured[:, 1] - y).max() < 1e-3
    assert np.abs(np.angle(np.exp(1j * (measured[:, 2] - yaw)))).max() < 1e-3
    assert np.abs(np.array(steered) - steer).max() < 1e-5
    twists = np.array([twist_of(message) for message in truth[1:]])  # the first is at rest
    expected = np.array([twist_at(*pair) for pair in zip(at(speed, times[1:]), steer[1:])])
    assert np.abs(twists - expected).max() < 1e-3


def test_the_steering_accelerates_cruises_and_slows_down_within_its_limits(files):
    robot = forklift(files, STEERING).drive(0.0, 0.6)

    angles = [steer_angle(robot)]
    for _ in range(500):
        angles.append(steer_angle(robot.run()))

    # Mean rates of the steps, against those of the trapezoid.
    rates = np.diff(angles) / 0.005
    middles = (np.arange(500) + 0.5) * 0.005
    assert rates == pytest.approx(at({0: 0, 1: 0.5, 1.45: 0.5, 1.95: 0}, middles), abs=1e-3)
    assert angles[-1] == pytest.approx(0.6, abs=1e-6)


@pytest.mark.parametrize(
    ("keys", "rate"),
    [
        pytest.param(
            ("max_angular_velocity: 0.25",),
            {0: 0.25, 2.4: 0.25, 2.4 + 1e-9: 0},
            id="velocity",
        ),
        pytest.param(
            # A triangle of 0.6 rad, up and down at 0.6 rad/s^2.
            ("max_steer_acceleration: 0.6",),
            {0: 0, 1: 0.6, 2: 0},
            id="acceleration, and deceleration",
        ),
        pytest.param(
            # 0.4 rad up in 2 s, 0.2 down in 1 s.
            ("max_steer_acceleration: 0.2", "angular_dynamics: {deceleration_limit: 0.4}"),
            {0: 0, 2: 0.4, 3: 0},
            id="acceleration beside a new deceleration",
        ),
        pytest.param(
            ("max_steer_acceleration: 0.5", "max_angular_velocity: 0.5"),
            {0: 0, 1: 0.5, 1.2: 0.5, 2.2: 0},
            id="both",
        ),
        pytest.param(
            ("max_angular_velocity: 9", "angular_dynamics: {velocity_limit: 0.25}"),
            {0: 0.25, 2.4: 0.25, 2.4 + 1e-9: 0},
            id="the new velocity limit wins",
        ),
        pytest.param(
            ("max_steer_acceleration: 9", "angular_dynamics: {acceleration_limit: 0.6}"),
            {0: 0, 1: 0.6, 2: 0},
            id="the new acceleration limit wins",
        ),
        pytest.param(
            ("max_angular_velocity: 0.25", "angular_dynamics: {velocity_limit: 0}"),
            {0: 0.25, 2.4: 0.25, 2.4 + 1e-9: 0},
            id="a new limit of 0 is none",
        ),
    ],
)
def test_deprecated_limits_are_obeyed_unless_there_are_new_ones(files, keys, rate):
    robot = forklift(files, *keys).drive(0.0, 0.6)

    angles = []
    for _ in range(700):
        angles.append(steer_angle(robot.run()))

    path = path_of({0: 0.0}, rate, 3.5)
    assert angles == pytest.approx(path["steer"][50::50], abs=1e-5)


def test_deprecated_limits_are_warned_of_where_they_stand(files, caplog):
    forklift(files, "max_angular_velocity: 0.25", "max_steer_acceleration: 0.6")

    where = files.folder / "robot.model.yaml"
    assert warnings(caplog) == [
        f"{where}:{FIRST_LINE}: plugins[0].max_angular_velocity: is deprecated; "
        "write angular_dynamics.velocity_limit",
        f"{where}:{FIRST_LINE + 1}: plugins[0].max_steer_acceleration: is deprecated; "
        "write angular_dynamics.acceleration_limit",
    ]


def test_new_limits_are_not_warned_of(files, caplog):
    forklift(files, STEERING, LINEAR, "max_steer_angle: 1")

    assert warnings(caplog) == []


# Commands


@pytest.mark.parametrize(
    ("speed", "angle"),
    [(math.nan, 0.0), (0.0, math.nan), (math.inf, 0.0), (0.0, -math.inf)],
)
def test_a_command_that_cannot_be_obeyed_is_ignored_with_a_warning(files, caplog, speed, angle):
    robot = forklift(files, entry=", namespace: robot1")
    robot.drive(0.5, topic="/robot1/cmd_vel").run(1.0)

    robot.drive(speed, angle, topic="/robot1/cmd_vel").run(1.0)

    [message] = warnings(caplog)
    assert "robot1/cmd_vel" in message
    assert f"linear.x={speed}" in message
    assert f"angular.z={angle}" in message
    assert robot.model().pose == pytest.approx((1.0, 0.0, 0.0), abs=1e-3)


def test_what_a_tricycle_cannot_do_is_not_looked_at(files, caplog):
    robot = forklift(files)
    twist = Twist()
    twist.linear.x, twist.linear.y, twist.angular.x = 0.5, math.nan, math.inf

    robot.transport.send("/cmd_vel", twist)
    robot.run(1.0)

    assert warnings(caplog) == []
    assert robot.model().pose == pytest.approx((0.5, 0.0, 0.0), abs=1e-3)


@pytest.mark.parametrize("limits", [(), (STEERING, LINEAR)])
def test_a_tricycle_that_is_moved_stands_still_as_it_is_steered(files, limits):
    robot = forklift(files, *limits).drive(1.0, 0.6).run(1.2)
    steered = steer_angle(robot)

    robot.world.move_model("robot", Pose(3.0, -2.0, 2.0))

    for _ in range(30):
        robot.run(0.1)
        assert robot.model().pose == pytest.approx((3.0, -2.0, 2.0), abs=1e-3)
        assert twist_of(robot.last(GROUND_TRUTH)) == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)
        assert steer_angle(robot) == pytest.approx(steered, abs=1e-3)
    for name, side in (("left_wheel", HALF_TRACK), ("right_wheel", -HALF_TRACK)):
        expected = Pose(3.0, -2.0, 2.0).apply(-WHEELBASE, side)
        assert robot.model().get_body(name).pose[:2] == pytest.approx(expected, abs=1e-3)


def test_a_tricycle_that_was_moved_drives_on_from_there_when_it_is_told(files):
    robot = forklift(files, LINEAR).drive(1.0, 0.0).run(3.0)
    robot.world.move_model("robot", Pose(3.0, -2.0, math.pi / 2))

    robot.run(1.0).drive(1.0, 0.0).run(2.0)

    # From rest: 1 m in 2 s at 0.5 m/s^2.
    assert robot.model().pose == pytest.approx((3.0, -1.0, math.pi / 2), abs=1e-3)


def test_a_wall_stops_it(files):
    wall = f"name: walls, map: {files.walls('wall', '2 -3 2 3')}"
    robot = forklift(files, layers=(wall,)).drive(0.5, 0.0).run(6.0)

    assert robot.model().pose.x == pytest.approx(2.0 - 0.2, abs=0.02)
    assert twist_of(robot.last(GROUND_TRUTH))[0] == pytest.approx(0.0, abs=0.02)


def test_it_can_be_deleted_in_mid_drive(files, caplog):
    robot = forklift(files).drive(1.0, 0.6).run(1.0)

    robot.world.delete_model("robot")
    robot.drive(1.0, 0.6).run(0.1)

    assert (robot.transport.topics, robot.transport.subscribed) == (set(), set())
    assert warnings(caplog) == []


# Odometry, topics and frames


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


@pytest.mark.parametrize(
    ("rate", "period"), [((), 5_000_000), (("pub_rate: inf",), 5_000_000), (("pub_rate: 50",), 2e7)]
)
def test_odometry_comes_at_its_rate_stamped_with_simulated_time(files, rate, period):
    messages = forklift(files, *rate).record(FILTERED, 1.0)

    stamps = [message.header.stamp.to_nsec() for message in messages]
    assert stamps == [round(i * period) for i in range(round(1e9 / period))]


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


# Geometry and configuration


def refusal(files, *keys: str, **options: Any) -> str:
    """Why a forklift is not loaded, without the folder's name and the line."""
    with pytest.raises(FlatlandError) as caught:
        forklift(files, *keys, **options)
    return str(caught.value).replace(f"{files.folder}/robot.model.yaml:", "")


def line_of(key: str) -> int:
    """Of one of the required keys."""
    return MODEL[: MODEL.index(key)].count("\n")


@pytest.mark.parametrize(
    ("replaced", "key", "message"),
    [
        pytest.param(
            ("front_wheel_joint: front", "front_wheel_joint: left"),
            "front_wheel_joint",
            "expected a revolute joint, found a weld joint",
            id="welded front wheel",
        ),
        pytest.param(
            ("rear_right_wheel_joint: right", "rear_right_wheel_joint: hub"),
            "rear_right_wheel_joint",
            "expected a weld joint, found a revolute joint",
            id="turning rear wheel",
        ),
        pytest.param(
            ("front_wheel_joint: front", "front_wheel_joint: hub"),
            "front_wheel_joint",
            'expected a joint of "base", found one of left_wheel and hub_cap',
            id="front wheel of another body",
        ),
        pytest.param(
            ("{name: base, anchor: [0, 0]}", "{name: base, anchor: [0.1, -0.2]}"),
            "front_wheel_joint",
            "expected the front wheel at the body's origin, found it at [0.1, -0.2]",
            id="front wheel ahead of the origin",
        ),
        pytest.param(
            ("{name: front_wheel, anchor: [0, 0]}", "{name: front_wheel, anchor: [0.1, 0]}"),
            "front_wheel_joint",
            "expected the anchor on the wheel at its origin, found it at [0.1, 0]",
            id="front wheel off its hub",
        ),
        pytest.param(
            ("{name: left_wheel, anchor: [0, 0]}", "{name: left_wheel, anchor: [0, -0.01]}"),
            "rear_left_wheel_joint",
            "expected the anchor on the wheel at its origin, found it at [0, -0.01]",
            id="rear left wheel off its hub",
        ),
        pytest.param(
            ("{name: right_wheel, anchor: [0, 0]}", "{name: right_wheel, anchor: [0, 0.01]}"),
            "rear_right_wheel_joint",
            "expected the anchor on the wheel at its origin, found it at [0, 0.01]",
            id="rear right wheel off its hub",
        ),
        pytest.param(
            ("rear_left_wheel_joint: left", "rear_left_wheel_joint: lefd"),
            "rear_left_wheel_joint",
            'the model has no joint "lefd" (did you mean "left"?); it has: front, left, right, hub',
            id="unknown joint",
        ),
        pytest.param(
            ("body: base", "body: bass"),
            "body: base",
            'the model has no body "bass" (did you mean "base"?); '
            "it has: base, front_wheel, left_wheel, right_wheel, hub_cap",
            id="unknown body",
        ),
    ],
)
def test_wheels_that_are_none_of_a_tricycle_are_refused_by_their_key(files, replaced, key, message):
    where = f"{line_of(key)}: plugins[0].{key.partition(':')[0]}"

    assert f"{where}: {message}" in refusal(files, replaced=replaced).split("\n")


@pytest.mark.parametrize(
    ("left", "right", "message"),
    [
        pytest.param(
            (0.0, 0.35),
            (0.0, -0.35),
            "expected the rear axle apart from the front wheel, found it there",
            id="wheels beside each other",
        ),
        pytest.param(
            (-1.0, 0.35),
            (-1.1, -0.35),
            "expected the rear axle at right angles to the way from its middle to the front wheel, "
            "found the rear wheels at [-1, 0.35] and [-1.1, -0.35]",
            id="aslant",
        ),
        pytest.param(
            (-1.0, 0.35),
            (-1.0, -0.3),
            "expected the rear axle at right angles to the way from its middle to the front wheel, "
            "found the rear wheels at [-1, 0.35] and [-1, -0.3]",
            id="off the middle",
        ),
        pytest.param(
            (-1.0, 0.0),
            (-1.0, 0.0),
            "expected the rear wheels apart from each other, found both at [-1, 0]",
            id="one rear wheel",
        ),
    ],
)
def test_a_rear_axle_that_is_none_is_refused(files, left, right, message):
    line = line_of("type: TricycleDrive")

    assert refusal(files, left=left, right=right) == f'{line}: plugins[0] "drive": {message}'


@pytest.mark.parametrize("key", ["front_wheel_joint", "rear_left_wheel_joint", "body"])
def test_what_is_required_must_be_there(files, key):
    found = refusal(files, replaced=(f"    {key}: ", f"    #{key}: "))

    message = f'plugins[0] "drive": the required key "{key}" is missing'
    assert found == f"{line_of('type: TricycleDrive')}: {message}"


LIMITS = ("acceleration_limit", "deceleration_limit", "velocity_limit")
KEYS = (
    "odom_frame_id", "pub_rate", "twist_sub", "odom_pub", "ground_truth_pub", "odom_pose_noise",
    "odom_twist_noise", "odom_pose_covariance", "odom_twist_covariance", "max_steer_angle",
    "angular_dynamics", "linear_dynamics", "max_angular_velocity", "max_steer_acceleration",
    "ground_truth_frame_id",
)  # fmt: skip


@pytest.mark.parametrize("key", KEYS)
def test_a_key_without_its_last_letter_is_refused_with_a_suggestion(files, key):
    message = f'plugins[0] "drive": unknown key "{key[:-1]}" (did you mean "{key}"?)'

    assert refusal(files, f"{key[:-1]}: 1") == f"{FIRST_LINE}: {message}"


@pytest.mark.parametrize("section", ["angular_dynamics", "linear_dynamics"])
@pytest.mark.parametrize("key", LIMITS)
def test_a_limit_without_its_last_letter_is_refused_with_a_suggestion(files, section, key):
    message = f'plugins[0].{section}: unknown key "{key[:-1]}" (did you mean "{key}"?)'

    assert refusal(files, f"{section}: {{{key[:-1]}: 1}}") == f"{FIRST_LINE}: {message}"


@pytest.mark.parametrize(
    ("key", "message"),
    [
        pytest.param(
            "max_steer_angle: -1",
            "plugins[0].max_steer_angle: expected a number of 0 or more, found -1",
            id="negative angle",
        ),
        pytest.param(
            "max_angular_velocity: -1",
            "plugins[0].max_angular_velocity: expected a number of 0 or more, found -1",
            id="negative deprecated limit",
        ),
        pytest.param(
            "angular_dynamics: {acceleration_limit: inf}",
            'plugins[0].angular_dynamics.acceleration_limit: expected a finite number, found "inf"',
            id="infinite limit",
        ),
    ],
)
def test_a_wrong_configuration_is_refused_at_its_line(files, key, message):
    assert refusal(files, key) == f"{FIRST_LINE}: {message}"
