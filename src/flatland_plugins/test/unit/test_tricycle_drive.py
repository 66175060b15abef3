"""TricycleDrive: its configuration, limits, odometry and frames."""

import math
from typing import Any, List

import pytest
from forklift import FIRST_LINE, LINEAR, MODEL, STEERING, WHEELBASE, forklift, steer_angle, twist_at
from logged import warnings
from readings import FILTERED, GROUND_TRUTH, pose_of, twist_of

from flatland_server.exceptions import FlatlandError
from flatland_server.geometry import Pose


def refusal(files, *keys: str, **options: Any) -> str:
    """The error of loading a forklift, without the names of folder and file."""
    with pytest.raises(FlatlandError) as caught:
        forklift(files, *keys, **options)
    return str(caught.value).replace(f"{files.folder}/robot.model.yaml:", "")


def line_of(key: str) -> int:
    """The line of one of the required keys."""
    return MODEL[: MODEL.index(key)].count("\n")


ANCHOR = "expected the anchor on the wheel at its origin, found it at"


@pytest.mark.parametrize(
    ("key", "old", "new", "message"),
    [
        ("front_wheel_joint", ": front", ": left", "expected a revolute joint, found a weld joint"),
        ("front_wheel_joint", ": front", ": hub", '"base", found one of left_wheel and hub_cap'),
        ("front_wheel_joint", "base, anchor: [0, 0]", "base, anchor: [1, 2]", "found it at [1, 2]"),
        ("front_wheel_joint", "wheel, anchor: [0, 0]", "wheel, anchor: [1, 0]", f"{ANCHOR} [1, 0]"),
        ("rear_right_wheel_joint", ": right", ": hub", "expected a weld joint, found a revolute"),
        ("rear_left_wheel_joint", ": left", ": lefd", 'has no joint "lefd" (did you mean "left"?)'),
        ("rear_left_wheel_joint", "left_wheel, anchor: [0,", "left_wheel, anchor: [1,", ANCHOR),
        ("rear_right_wheel_joint", "right_wheel, anchor: [0,", "right_wheel, anchor: [1,", ANCHOR),
        ("body", ": base\n", ": bass\n", 'the model has no body "bass" (did you mean "base"?)'),
    ],
)
def test_wheels_unfit_for_a_tricycle_are_refused_by_their_key(files, key, old, new, message):
    if old.startswith(": "):
        old, new = f"{key}{old}", f"{key}{new}"
    found = refusal(files, replaced=(old, new)).split("\n")

    where = f"{line_of(f'    {key}: ')}: plugins[0].{key}: "
    assert [each for each in found if each.startswith(where) and message in each]


@pytest.mark.parametrize(
    ("left", "right", "message"),
    [
        ((0.0, 0.35), (0.0, -0.35), "expected the rear axle apart from the front wheel, found it"),
        ((-1.0, 0.35), (-1.1, -0.35), "expected the rear axle at right angles to the way from its"),
        ((-1.0, 0.35), (-1.0, -0.3), "found the rear wheels at [-1, 0.35] and [-1, -0.3]"),
        ((-1.0, 0.0), (-1.0, 0.0), "apart from each other, found both at [-1, 0]"),
    ],
    ids=["beside the front wheel", "aslant", "off the middle", "one rear wheel"],
)
def test_rear_wheels_that_form_no_axle_are_refused(files, left, right, message):
    found = refusal(files, left=left, right=right)

    assert found.startswith(f'{line_of("type: TricycleDrive")}: plugins[0] "drive": expected the')
    assert message in found


def test_the_limits_are_those_of_the_speed_and_of_the_steering(files):
    robot = forklift(files, STEERING, LINEAR)

    found = []
    for speed, angle, seconds in ((1.0, 0.6, 1.0), (1.0, 0.6, 3.0), (0.0, 0.6, 1.0)):
        robot.drive(speed, angle).run(seconds)
        vx, vy, _ = twist_of(robot.last(GROUND_TRUTH))
        found.append((math.hypot(vx, vy), steer_angle(robot)))

    # By 0.5 m/s^2 and 0.5 rad/s^2 for a second; at the end; 0.8 m/s^2 less after another second.
    expected = [(0.5, 0.25), (1.0, 0.6), (0.2, 0.6)]
    assert [pytest.approx(each, abs=5e-3) for each in expected] == found


def steering(files, *keys: str) -> List[float]:
    """The angles of the front wheel after a command, at each step."""
    robot = forklift(files, *keys).drive(0.0, 0.6)
    return [steer_angle(robot.run()) for _ in range(700)]


SPEED, ACCELERATION = "max_angular_velocity", "max_steer_acceleration"


@pytest.mark.parametrize(
    ("deprecated", "new", "limits"),
    [
        (f"{SPEED}: 0.25", "", "velocity_limit: 0.25"),
        (f"{SPEED}: 9", "velocity_limit: 0.25", "velocity_limit: 0.25"),
        (f"{SPEED}: 0.25", "velocity_limit: 0", "velocity_limit: 0.25"),
        (f"{ACCELERATION}: 0.6", "", "acceleration_limit: 0.6, deceleration_limit: 0.6"),
        (f"{ACCELERATION}: 9", "acceleration_limit: 0.6", "acceleration_limit: 0.6"),
        (
            f"{ACCELERATION}: 0.2\n    {SPEED}: 0.4",
            "deceleration_limit: 0.4",
            "acceleration_limit: 0.2, deceleration_limit: 0.4, velocity_limit: 0.4",
        ),
    ],
)
def test_deprecated_limits_are_obeyed_unless_there_are_new_ones(files, deprecated, new, limits):
    obeyed = steering(files, deprecated, f"angular_dynamics: {{{new}}}")

    assert obeyed == steering(files, f"angular_dynamics: {{{limits}}}")


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


FROM_THE_WORLD = (
    "plugins:",
    "plugins:\n  - {type: ModelTfPublisher, name: tf, publish_tf_world: true}",
)


def parent_of_the_base(robot) -> str:
    return str(robot.transport.transforms["base"].parent)


def test_by_default_the_world_can_be_the_parent_of_its_body(files, caplog):
    robot = forklift(files, replaced=FROM_THE_WORLD).run(0.1)

    assert parent_of_the_base(robot) == "map"
    assert warnings(caplog) == []


def test_the_transform_is_published_if_it_is_asked_for(files):
    robot = forklift(files, "enable_odom_tf_pub: true").drive(0.8, 0.5).run(1.0)

    assert parent_of_the_base(robot) == "odom"
    transform = robot.transport.transforms["base"]
    assert tuple(transform.pose) == pytest.approx(pose_of(robot.last(FILTERED)), abs=1e-9)
