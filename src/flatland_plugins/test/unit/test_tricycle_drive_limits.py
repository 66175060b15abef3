"""TricycleDrive: speed and steering within limits, new ones and deprecated ones."""

import math
from typing import Any, Dict, List, Tuple

import numpy as np
import pytest
from forklift import FIRST_LINE, LINEAR, STEERING, WHEELBASE, forklift, steer_angle, twist_at
from readings import GROUND_TRUTH, pose_of, twist_of, warnings

from flatland_server.timekeeper import Timekeeper

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
