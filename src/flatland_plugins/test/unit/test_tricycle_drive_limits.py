"""TricycleDrive: speed and steering within limits, new ones and deprecated ones."""

from typing import Any, Dict, List

import numpy as np
import pytest
from forklift import FIRST_LINE, LINEAR, STEERING, WHEELBASE, forklift, steer_angle, twist_at
from readings import GROUND_TRUTH, pose_of, twist_of, warnings

Curve = Dict[float, float]


def at(curve: Curve, times: np.ndarray) -> np.ndarray:
    """A value interpolated linearly between the given times; two close times make a jump."""
    return np.interp(times, list(curve), list(curve.values()))


def path_of(speed: Curve, rate: Curve, duration: float) -> Dict[str, np.ndarray]:
    """The path of a front wheel's speed and steering rate, by midpoints of 0.1 ms."""
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


# Commands (speed, angle) by time; the speed and the steering rate at their curves' corners.
COMMANDS = {0: (1.0, 0.6), 4: (1.0, -0.4), 8: (0.0, -0.4)}
SPEED = {0: 0.0, 2: 1.0, 8: 1.0, 9.25: 0.0}
RATE = {0: 0, 1: 0.5, 1.45: 0.5, 1.95: 0, 4: 0, 5: -0.5, 6.25: -0.5, 6.75: 0}


def test_within_limits_it_follows_the_integral_of_its_exact_speed_and_steering(files):
    robot = forklift(files, STEERING, LINEAR)

    truth: List[Any] = []
    steered: List[float] = []
    starts = list(COMMANDS)
    for start, end in zip(starts, [*starts[1:], 10]):
        robot.drive(*COMMANDS[start])
        for _ in range(round((end - start) / 0.005)):
            steered.append(steer_angle(robot))
            truth.append(robot.run().last(GROUND_TRUTH))

    path = path_of(SPEED, RATE, 10.0)
    times = np.array([message.header.stamp.to_sec() for message in truth])
    x, y, yaw, steer = (np.interp(times, path["time"], path[k]) for k in ("x", "y", "yaw", "steer"))
    measured = np.array([pose_of(message) for message in truth])
    assert np.abs(measured[:, 0] - x).max() < 1e-3
    assert np.abs(measured[:, 1] - y).max() < 1e-3
    assert np.abs(np.angle(np.exp(1j * (measured[:, 2] - yaw)))).max() < 1e-3
    assert np.abs(np.array(steered) - steer).max() < 1e-5
    twists = np.array([twist_of(message) for message in truth[1:]])  # the first is at rest
    expected = np.array([twist_at(*pair) for pair in zip(at(SPEED, times[1:]), steer[1:])])
    assert np.abs(twists - expected).max() < 1e-3


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
