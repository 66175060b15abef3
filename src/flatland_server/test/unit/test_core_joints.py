"""Limits and motors of joints, set while the world runs."""

import math
from typing import Any, List, Tuple

import pytest

from flatland_server import _core

DT = 0.005
INERTIA = 0.5 * 2.0 * 0.2**2
"""Of the wheel, about its hub [kg m^2]: a disc of 2 kg."""


class Hinge:
    """A wheel on a static body."""

    def __init__(self) -> None:
        self.world = _core.World()
        self.post = self.world.add_body("static", (0.0, 0.0, 0.0))
        self.wheel = self.world.add_body("dynamic", (0.0, 0.0, 0.0))
        self.wheel.add_circle((0.0, 0.0), 0.2, density=2.0 / (math.pi * 0.2**2))
        self.joint = self.post.add_revolute(self.wheel, (0.0, 0.0), (0.0, 0.0))

    def step(self, count: int) -> List[float]:
        """Makes steps; the angles after each."""
        angles = []
        for _ in range(count):
            self.world.step(DT)
            angles.append(self.joint.angle)
        return angles


@pytest.fixture
def hinge() -> Hinge:
    return Hinge()


def test_a_joint_is_free_and_without_a_motor_until_it_gets_one(hinge):
    assert (hinge.joint.limits, hinge.joint.motor, hinge.joint.motor_torque) == (None, None, 0.0)
    limited = hinge.post.add_revolute(hinge.wheel, (0, 0), (0, 0), limits=(-0.5, 0.25))
    assert limited.limits == (-0.5, 0.25)


def test_a_motor_accelerates_with_its_torque_up_to_its_speed(hinge):
    hinge.joint.motor = (3.0, 0.5)
    assert hinge.joint.motor == (3.0, 0.5)

    hinge.step(4)

    assert hinge.joint.speed == pytest.approx(4 * DT * 0.5 / INERTIA, rel=1e-4)
    assert hinge.joint.motor_torque == pytest.approx(0.5, rel=1e-5)
    hinge.step(60)
    assert hinge.joint.speed == pytest.approx(3.0, rel=1e-5)
    assert hinge.joint.motor_torque == pytest.approx(0.0, abs=1e-4)
    hinge.joint.motor = (0.0, 0.1)  # a brake
    hinge.step(1)
    assert hinge.joint.speed == pytest.approx(3.0 - DT * 0.1 / INERTIA, rel=1e-5)
    hinge.joint.motor = None
    before = hinge.joint.speed
    hinge.step(50)
    assert hinge.joint.speed == before


def test_a_motor_wakes_a_body_at_rest(hinge):
    hinge.step(300)
    assert not hinge.wheel.awake

    hinge.joint.motor = (1.0, 1.0)
    hinge.step(20)

    assert hinge.joint.speed == pytest.approx(1.0, rel=1e-5)


def test_limits_can_be_set_moved_and_taken_away(hinge):
    slop = math.radians(2.1)  # Box2D lets a limit give by 2 degrees (b2_angularSlop)
    hinge.joint.motor = (2.0, 1.0)
    for upper in (0.5, 1.0, 0.2):
        hinge.joint.limits = (-0.25, upper)
        assert hinge.joint.limits == pytest.approx((-0.25, upper), rel=1e-6)
        assert hinge.step(300)[-1] == pytest.approx(upper, abs=slop)
    hinge.joint.limits = None
    assert max(hinge.step(600)) > 3.0


def test_limits_beyond_a_rotation_count_rotations(hinge):
    hinge.joint.limits = (0.0, 7.5)
    hinge.step(1)
    assert hinge.joint.angle == 0.0
    hinge.joint.motor = (4.0, 1.0)
    hinge.step(1000)
    assert hinge.joint.angle == pytest.approx(7.5 - math.tau, abs=0.04)

    hinge.joint.limits = (0.0, 7.0)  # half a radian back, not a rotation more

    angles = hinge.step(200)
    assert min(angles) > 6.9 - math.tau
    assert angles[-1] == pytest.approx(7.0 - math.tau, abs=0.04)


WRONG = [
    *(("limits", value) for value in ((math.nan, 1.0), (0.0, math.inf), (0.5, 0.4), (-1e10, 1.0))),
    *(("motor", value) for value in ((math.nan, 1.0), (math.inf, 1.0))),
    *(("motor", (1.0, torque)) for torque in (-0.1, math.nan, math.inf)),
]


@pytest.mark.parametrize(("name", "value"), WRONG)
def test_wrong_values_are_refused_and_change_nothing(hinge, name, value):
    hinge.joint.limits, hinge.joint.motor = (-0.5, 0.25), (2.0, 1.0)
    before = hinge.world.save_state()

    with pytest.raises(ValueError, match="a joint's limits" if name == "limits" else "a motor's"):
        setattr(hinge.joint, name, value)

    assert hinge.world.save_state() == before


@pytest.mark.parametrize("value", [(1.0,), (1.0, 2.0, 3.0), 1.0, "ab", {}])
@pytest.mark.parametrize("name", ["limits", "motor"])
def test_other_types_are_refused(hinge, name, value):
    with pytest.raises(TypeError):
        setattr(hinge.joint, name, value)
    assert getattr(hinge.joint, name) is None


@pytest.mark.parametrize("name", ["limits", "motor", "motor_torque"])
def test_a_weld_has_no_limits_and_no_motor(hinge, name):
    weld = hinge.post.add_weld(hinge.wheel, (0, 0), (0, 0))

    with pytest.raises(ValueError, match="a weld has no limits and no motor"):
        getattr(weld, name)
    if name != "motor_torque":
        with pytest.raises(ValueError, match="a weld has no limits and no motor"):
            setattr(weld, name, None)
    assert weld.speed == 0.0


def arm_before_a_wall() -> Tuple[_core.World, _core.Joint, _core.Body, List[Any]]:
    """A motor turns an arm against a wall; with the list of the values seen at each contact."""
    world = _core.World()
    world.add_layer([[-1.0, 0.5, 2.0, 0.5]], 1)
    post, arm = (world.add_body(kind, (0.0, 0.0, 0.0)) for kind in ("static", "dynamic"))
    arm.add_polygon([(0.0, -0.05), (1.0, -0.05), (1.0, 0.05), (0.0, 0.05)], density=1, layers=1)
    joint = post.add_revolute(arm, (0.0, 0.0), (0.0, 0.0))
    joint.motor = (2.0, 5.0)
    arm.listen_to_contacts(15)
    return world, joint, arm, []


@pytest.mark.parametrize(
    "event", [_core.BEGIN_CONTACT, _core.PRE_SOLVE, _core.POST_SOLVE, _core.END_CONTACT]
)
def test_settings_in_a_contact_listener_act_after_the_step(event):
    world, joint, arm, seen = arm_before_a_wall()

    def listen(now: int, *_: Any) -> None:
        if now == event and not seen:
            joint.motor, joint.limits = (-1.0, 4.0), (-0.3, 2.0)
            arm.set_mass(7.0, inertia=2.0, local_center=(0.5, 0.1))
            with pytest.raises(ValueError, match="a motor's"):
                joint.motor = (math.nan, 1.0)
            seen.append((joint.motor, joint.limits, arm.mass))

    world.set_contact_listener(listen)
    for step in range(200):
        if step == 150 and event == _core.END_CONTACT:
            joint.motor = (-2.0, 5.0)
        world.step(DT)

        if seen:
            break

    assert seen == [((-2.0 if event == _core.END_CONTACT else 2.0, 5.0), None, pytest.approx(0.1))]
    assert (joint.motor, joint.limits) == ((-1.0, 4.0), pytest.approx((-0.3, 2.0)))
    assert (arm.mass, arm.local_center) == (7.0, pytest.approx((0.5, 0.1)))
    for _ in range(400):
        world.step(DT)
    assert joint.angle == pytest.approx(-0.3, abs=0.04)


def test_a_listener_may_set_joints_while_a_body_is_removed():
    """The removed body's own are gone by then."""
    world, joint, arm, seen = arm_before_a_wall()
    box = world.add_body("dynamic", (0.6, -0.14, 0.0))
    box.add_circle((0.0, 0.0), 0.1, density=1, layers=1)
    of_box = box.add_revolute(world.add_body("static", (0.6, -0.14, 0.0)), (0, 0), (0, 0))
    joint.motor = (-1.0, 1.0)
    for _ in range(20):
        world.step(DT)
    assert world.touches

    def listen(*_: Any) -> None:
        joint.motor = (1.5, 2.5)
        with pytest.raises(_core.GoneError):
            of_box.motor = (1.0, 1.0)
        seen.append(joint.motor)

    world.set_contact_listener(listen)
    box.remove()

    assert seen == [(-1.0, 1.0)]
    assert joint.motor == (1.5, 2.5)
    arm.remove()
    world.step(DT)
