"""AckermannDrive: against closed forms and CommonRoad's single-track model, its limits and keys."""

import math
from types import SimpleNamespace
from typing import Any, List, Tuple

import numpy as np
import pytest
from logged import warnings
from scipy.integrate import solve_ivp

from flatland_server import _core, messages
from flatland_server.exceptions import FlatlandError
from flatland_server.geometry import Pose

Stamped = messages.get("ackermann_msgs/AckermannDriveStamped")

# m, I, lr, h, mu and both cornering stiffnesses; then wheelbase, and the greatest acceleration.
RACECAR = (3.74, 0.04712, 0.17145, 0.074, 1.0489, 5.0, 5.0), 0.3302, 9.51
BMW_320I = (1093.3, 1791.6, 1.4227, 0.5747, 1.0489, 20.898, 20.898), 2.5789, 11.5
STEERING_RATE = 0.4


def car(numbers: Any = None, wheelbase: float = 0.33, **limits: Any) -> Tuple[Any, Any, Any]:
    """A world, a body in it, and the body's drive."""
    world = _core.World()
    body = world.add_body("dynamic", (0.0, 0.0, 0.0))
    body.add_circle((0.1, 0.0), 0.2, density=10.0)
    return world, body, body.add_ackermann(wheelbase, 1.0, single_track=numbers, **limits)


@pytest.mark.parametrize("step", [0.001, 0.005, 0.1])
@pytest.mark.parametrize(("speed", "angle"), [(1.0, 0.4), (0.5, -0.7), (-0.8, 0.3)])
def test_it_drives_arcs(step, speed, angle):
    world, body, drive = car(linear_limits=(0.5, 0.5, 0.0))
    drive.command(0.0, angle)  # turns its wheels at rest
    world.step(step)
    drive.command(speed, angle)
    radius = 0.33 / math.tan(angle)
    for count in range(1, round(4.0 / step) + 1):
        world.step(step)
        time = count * step
        ramp = min(time, 2.0 * abs(speed))
        turned = math.copysign(0.25 * ramp**2, speed) / radius + speed / radius * (time - ramp)
        x, y, yaw = body.pose
        expected = radius * math.sin(turned), radius * (1.0 - math.cos(turned))
        assert (x, y) == pytest.approx(expected, abs=1e-6)
        assert math.remainder(yaw - turned, math.tau) == pytest.approx(0.0, abs=1e-6)


COMMANDS = ((0.0, 3.0, 0.1), (1.5, 5.0, -0.08), (3.0, 2.0, 0.15), (4.0, 4.0, 0.0))
"""Times [s], speeds [m/s] and angles [rad]."""
END = 5.0


def commonroad(numbers: Tuple[float, ...], wheelbase: float, acceleration: float) -> List[float]:
    """CommonRoad's state at the end, of commands that are obeyed at the greatest rates."""
    dynamics = pytest.importorskip("vehiclemodels.vehicle_dynamics_st").vehicle_dynamics_st
    mass, inertia, rear, height, friction, stiffness, _ = numbers
    wide = SimpleNamespace(min=-9.0, max=9.0, v_min=-9.0, v_max=9.0)
    limits = SimpleNamespace(v_switch=99.0, a_max=99.0, v_min=-99.0, v_max=99.0)
    tyre = SimpleNamespace(p_dy1=friction, p_ky1=-friction * stiffness)
    car = {"a": wheelbase - rear, "b": rear, "h_s": height, "m": mass, "I_z": inertia}
    parameters = SimpleNamespace(tire=tyre, steering=wide, longitudinal=limits, **car)
    state, time = [rear, *[0.0] * 6], 0.0
    ends = [*[each[0] for each in COMMANDS[1:]], END]
    for (_, speed, angle), end in zip(COMMANDS, ends):
        while end - time > 1e-9:
            u = [0.0, 0.0]
            until = end
            for k, (target, rate) in enumerate(((angle, STEERING_RATE), (speed, acceleration))):
                way = target - state[2 + k]
                if abs(way) > 1e-9:
                    u[k] = math.copysign(rate, way)
                    until = min(until, time + abs(way) / rate)
            if state[3] < 0.1 - 1e-9 and u[1] > 0.0:  # there the model is another one
                until = min(until, time + (0.1 - state[3]) / u[1])
            precise = {"method": "DOP853", "rtol": 1e-10, "atol": 1e-12}
            rates = lambda _, x, u=u: dynamics(x, u, parameters)  # noqa: E731
            state = solve_ivp(rates, (time, until), state, **precise).y[:, -1].tolist()
            time = until
    return state


def ours(numbers: Any, wheelbase: float, acceleration: float, step: float) -> List[float]:
    """The pose of the centre of mass at the end of the same commands."""
    limits = {"linear_limits": (acceleration, acceleration, 0.0)}
    limits["steering_limits"] = (0.0, 0.0, STEERING_RATE)
    world, body, drive = car(numbers, wheelbase, **limits)
    commands = list(COMMANDS)
    for count in range(round(END / step)):
        if commands and count >= round(commands[0][0] / step):
            drive.command(*commands.pop(0)[1:])
        world.step(step)
    return [*Pose(*body.pose).compose(Pose(numbers[2])), drive.slip_angle]


@pytest.mark.parametrize("vehicle", [RACECAR, BMW_320I], ids=["racecar", "BMW 320i"])
def test_with_slip_it_drives_as_commonroads_single_track_model(vehicle):
    state = commonroad(*vehicle)
    expected = [state[0], state[1], state[4], state[6]]

    errors = [np.abs(np.array(ours(*vehicle, step)) - expected) for step in (0.01, 0.005, 0.001)]

    assert errors[2].max() < 1e-4
    # Second order: a quarter with steps of half the length.
    assert math.hypot(*errors[1][:2]) < 0.35 * math.hypot(*errors[0][:2])


def test_its_tyres_slip():
    """The rear tyres slip by a / (mu C g) at a lateral acceleration a; without slip, they roll."""
    for numbers in (RACECAR[0], None):
        world, body, drive = car(numbers, 0.3302)
        drive.command(3.0, 0.1)
        for _ in range(400):
            world.step(0.005)
        along, across, turn = body.local_velocity
        angle = 3.0 * turn / (1.0489 * 5.0 * 9.81) if numbers else 0.0
        assert across == pytest.approx(-angle * along, abs=2e-3)


@pytest.mark.parametrize("step", [0.005, 0.1])
def test_random_commands_keep_pose_and_velocity_finite(step):
    """Oversteering beyond the critical speed, in jumps, backwards and at a crawl."""
    rng = np.random.default_rng(1)
    numbers = (1.0, 0.001, 0.3, 0.5, 1.5, 30.0, 0.1)
    world, body, drive = car(numbers, 0.33)
    for _ in range(200):
        drive.command(rng.choice([1e9, 30.0, 0.1, 0.0, -0.1, -1e9]), rng.uniform(-2, 2))
        for _ in range(5):
            world.step(step)
            assert np.isfinite([*body.pose, *body.velocity, drive.slip_angle]).all()


def test_a_jerk_limit_ramps_the_acceleration():
    world, body, drive = car(linear_limits=(2.0, 4.0, 0.0), jerk_limit=5.0)
    drive.command(3.0, 0.0)
    speeds = [0.0]
    for _ in range(2500):
        world.step(0.001)
        speeds.append(drive.speed)
    # 0.4 s up to 2 m/s^2, 1.1 s at it, 0.4 s down.
    assert speeds[200] == pytest.approx(0.5 * 5.0 * 0.2**2, abs=1e-9)
    assert speeds[1000] == pytest.approx(0.4 + 2.0 * 0.6, abs=1e-9)
    assert speeds[1900] == pytest.approx(3.0, abs=1e-9)
    accelerations = np.diff(speeds) / 0.001
    assert accelerations.max() == pytest.approx(2.0, abs=1e-6)
    assert np.abs(np.diff(accelerations)).max() == pytest.approx(0.005, abs=1e-6)
    assert body.pose[0] == pytest.approx(sum(speeds[:-1]) * 0.001 + 0.0015, abs=1e-5)

    drive.command(-1.0, 0.0)
    while drive.speed > -1.0:
        before = drive.speed
        world.step(0.001)
        assert abs(drive.speed - before) <= 4.0 * 0.001 + 1e-9


MODEL = """
bodies:
  - {name: base_link, footprints: [{type: polygon, density: 20,
     points: [[-0.1, -0.15], [0.45, -0.15], [0.45, 0.15], [-0.1, 0.15]]}]}
  - {name: left, pose: [0.33, 0.12, 0], footprints: [WHEEL]}
  - {name: right, pose: [0.33, -0.12, 0], footprints: [WHEEL]}
joints:
  - {type: revolute, name: left, bodies: [{name: base_link, anchor: [0.33, 0.12]},
     {name: left, anchor: [0, 0]}]}
  - {type: revolute, name: right, bodies: [{name: right, anchor: [0, 0]},
     {name: base_link, anchor: [0.33, -0.12]}]}
plugins:
  - type: AckermannDrive
    name: drive
    body: base_link
    max_steer_angle: 0.5
    front_left_wheel_joint: left
    front_right_wheel_joint: right
    KEYS
""".replace("WHEEL", "{type: circle, radius: 0.05, density: 1, layers: []}")
SLIP = (
    "single_track: {mass: 3.74, inertia: 0.047, center_of_mass: 0.17, height: 0.074, "
    "friction: 1.05, front_stiffness: 4.7, rear_stiffness: 5.5}"
)


def racecar(files: Any, *keys: str, namespace: str = "") -> Any:
    lines = "\n    ".join(["wheelbase: 0.33", *keys])
    files.write("robot.model.yaml", MODEL.lstrip("\n").replace("KEYS", lines))
    return files.load_models({"robot": f"model: robot.model.yaml, namespace: '{namespace}'"})


def drive_message(speed: float, angle: float, **limits: float) -> Any:
    drive_type = messages.get("ackermann_msgs/AckermannDrive")
    return Stamped(drive=drive_type(speed=speed, steering_angle=angle, **limits))


def core_of(robot: Any) -> Any:
    return robot.world.plugins_of("robot")["drive"].batch_role.drive.drive


@pytest.mark.parametrize("stamped", [True, False])
def test_it_obeys_the_messages_of_ackermann_msgs(files, stamped):
    robot, message = racecar(files, "ackermann_sub: /drive"), drive_message(1.0, 0.3)
    sent = ("/drive", message) if stamped else ("/ackermann_drive", message.drive)
    robot.send(*sent).run(2.0)

    turned = 2.0 * math.tan(0.3) / 0.33
    radius = 2.0 / turned
    expected = radius * math.sin(turned), radius * (1.0 - math.cos(turned))
    assert robot.model().pose[:2] == pytest.approx(expected, abs=1e-5)


def test_limits_in_a_message_apply_to_its_command(files):
    robot = racecar(files, "linear_dynamics: {acceleration_limit: 4}")
    limits = {"steering_angle_velocity": 0.5, "acceleration": 2.0}
    robot.transport.send("/ackermann_cmd", drive_message(3.0, 0.4, **limits))

    robot.run(0.5)

    assert core_of(robot).speed == pytest.approx(1.0, abs=1e-6)
    assert core_of(robot).steer_angle == pytest.approx(0.25, abs=1e-6)


@pytest.mark.parametrize(
    ("keys", "speed", "turn", "angle"),
    [
        ((), 1.0, 0.5, math.atan(0.33 * 0.5)),
        ((), -1.0, 0.5, -math.atan(0.33 * 0.5)),
        ((), 0.0, 0.5, 0.0),
        ((), 0.1, 9.0, 0.5),
        (("cmd_angle_instead_rotvel: true",), 0.0, 0.3, 0.3),
    ],
)
def test_a_twist_commands_the_yaw_rate_or_the_angle(files, keys, speed, turn, angle):
    robot = racecar(files, *keys).drive(speed, turn).run(0.5)

    assert core_of(robot).steer_angle == pytest.approx(angle, abs=1e-12)
    if not keys and angle not in (0.0, 0.5):
        assert robot.model().base.physics_body.local_velocity[2] == pytest.approx(turn, abs=1e-5)


@pytest.mark.parametrize("wrong", [{"speed": math.nan}, {"acceleration": -1.0}])
def test_an_impossible_message_is_ignored_with_a_warning(files, caplog, wrong):
    robot = racecar(files, namespace="r1")
    robot.transport.send("/r1/ackermann_cmd", drive_message(1.0, 0.1))
    robot.run(0.1)
    for _ in range(2):
        message = drive_message(**{"speed": 2.0, "angle": 0.3, **wrong})
        robot.transport.send("/r1/ackermann_cmd", message)
        robot.run(0.1)

    [message] = warnings(caplog)
    assert "r1/ackermann_cmd" in message
    assert "ignored speed=" in message
    assert core_of(robot).speed == 1.0


@pytest.mark.parametrize("keys", [(), (SLIP,)], ids=["rolling", "slipping"])
def test_the_axes_of_its_wheels_meet_in_one_point(files, keys):
    robot = racecar(files, *keys).drive(1.0, 0.0).run(0.1)
    robot.world.plugins_of("robot")["drive"].command(1.0, 0.4)
    robot.run(0.5)

    bodies = robot.model().bodies
    base, left, right = (bodies[name].pose for name in ("base_link", "left", "right"))
    center = 0.33 / math.tan(0.4)
    for wheel, y in ((left, 0.12), (right, -0.12)):
        angle = math.remainder(wheel.yaw - base.yaw, math.tau)
        assert angle == pytest.approx(math.atan(0.33 / (center - y)), abs=1e-5)
    assert base.inverse().compose(left)[:2] == pytest.approx((0.33, 0.12), abs=1e-5)


def test_with_slip_its_body_has_the_cars_mass(files):
    body = racecar(files, SLIP).model().base.physics_body

    assert (body.mass, body.inertia) == pytest.approx((3.74, 0.047))
    assert body.local_center == pytest.approx((0.17, 0.0))


def test_an_ackermann_drive_may_have_actuators(files):
    """A delay of both axes, and traction: it speeds up by mu g, whatever it is commanded."""
    keys = "{delay: 0.1, linear: {time_constant: 0.5}, traction: {friction: 0.1}}"
    robot = racecar(files, f"actuators: {keys}", SLIP).drive(0.0, 0.0).run(0.1)
    robot.world.plugins_of("robot")["drive"].command(9.0, 0.01)
    robot.run(0.1)
    assert (core_of(robot).speed, core_of(robot).steer_angle) == (0.0, 0.0)

    robot.run(1.0)

    assert core_of(robot).steer_angle == 0.01
    assert core_of(robot).speed == pytest.approx(9.0 * (1.0 - math.exp(-2.0)), rel=1e-2)
    body = robot.model().base.physics_body
    assert math.hypot(*body.velocity_at(body.center)) == pytest.approx(0.1 * 9.81, rel=0.05)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("max_steer_angle: 0.5", "max_steer_angle: 90", "below a right one, found 90"),
        ("wheelbase: 0.33", "wheelbase: 0.4", "on the front axle, at x = 0.4, found x = 0.33"),
        ("wheelbase: 0.33", "wheelbase: 0", "expected a number above 0, found 0"),
        ("_joint: left", "_joint: lefd", 'no joint "lefd" (did you mean "left"?)'),
        ("mass: 0.17", "mass: 0.33", "below the wheelbase, 0.33, found 0.33"),
        ("friction", "fricton", 'unknown key "fricton" (did you mean "friction"?)'),
        (", rear_stiffness: 5.5", "", 'required key "rear_stiffness" is missing'),
        (SLIP, "jerk_limit: -1", "expected a number of 0 or more, found -1"),
    ],
)
def test_wrong_keys_are_refused(files, old, new, message):
    text = MODEL.lstrip("\n").replace("KEYS", "wheelbase: 0.33\n    " + SLIP)
    assert old in text
    files.write("robot.model.yaml", text.replace(old, new, 1))

    with pytest.raises(FlatlandError) as caught:
        files.load_models({"robot": "model: robot.model.yaml"})

    assert message in str(caught.value)
    assert "robot.model.yaml:" in str(caught.value)
