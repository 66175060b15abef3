"""Masses of bodies, set while the world runs."""

import math

import pytest

from flatland_server import _core

DT = 0.005
DISC = {"density": 1.0 / math.pi, "layers": 1}
"""A disc with a radius of 1 m has 1 kg and 0.5 kg m^2."""


@pytest.fixture
def world() -> _core.World:
    return _core.World()


@pytest.fixture
def body(world) -> _core.Body:
    """A disc of 1 kg around the point (0.5, 0) of its frame, at a quarter turn."""
    body = world.add_body("dynamic", (3.0, 4.0, math.pi / 2))
    body.add_circle((0.5, 0.0), 1.0, **DISC)
    return body


def masses(body) -> list:
    return [body.mass, body.inertia, *body.local_center]


def test_forces_act_on_the_mass_and_inertia_that_were_set(world, body):
    body.set_mass(4.0, inertia=0.7, local_center=(0.2, -0.1))

    assert masses(body) == pytest.approx([4.0, 0.7, 0.2, -0.1], rel=1e-6)
    assert body.center == pytest.approx((3.1, 4.2), rel=1e-6)
    body.apply_force((0.0, 8.0), (4.1, 4.2))  # a metre beside the centre
    world.step(DT)
    assert body.velocity[2] == pytest.approx(DT * 8.0 / 0.7, rel=1e-5)
    vx, vy = body.velocity_at(body.center)
    assert (vx, vy) == pytest.approx((0.0, DT * 8.0 / 4.0), rel=1e-4, abs=1e-6)


def test_set_mass_keeps_the_centre_and_scales_the_inertia(body):
    body.set_mass(3.0)
    assert masses(body) == pytest.approx([3.0, 1.5, 0.5, 0.0], rel=1e-6)
    body.set_mass(1.0, local_center=(0.0, 0.25))
    assert masses(body) == pytest.approx([1.0, 0.5, 0.0, 0.25], rel=1e-6)
    body.set_mass(2.0, inertia=0.3)
    assert masses(body) == pytest.approx([2.0, 0.3, 0.0, 0.25], rel=1e-6)


def test_the_velocity_of_the_origin_stays(body):
    body.velocity = (1.0, -0.5, 2.0)

    body.set_mass(3.0, local_center=(-0.4, 0.3))

    assert body.velocity == pytest.approx((1.0, -0.5, 2.0), rel=1e-6)
    assert body.pose == pytest.approx((3.0, 4.0, math.pi / 2))


def test_the_mass_of_the_fixtures_comes_back(body):
    before = masses(body)
    for end in (
        body.reset_mass,
        lambda: body.fixture(0).set_circle((0.5, 0.0), 1.0),
    ):
        body.set_mass(4.0, inertia=0.7, local_center=(0.2, -0.1))
        body.add_circle((0.0, 0.0), 1.0, density=0.0)
        assert body.mass == 4.0
        end()
        assert masses(body) == before
    body.set_mass(4.0)
    body.add_circle((-0.5, 0.0), 1.0, **DISC)
    assert masses(body) == pytest.approx([2.0, 2 * (0.5 + 0.25), 0.0, 0.0], rel=1e-5, abs=1e-6)


def test_a_body_without_density_may_get_a_mass(world):
    """Box2D gives it 1 kg, and it does not turn."""
    body = world.add_body("dynamic", (0.0, 0.0, 0.0))
    assert masses(body) == [1.0, 0.0, 0.0, 0.0]
    body.set_mass(2.0)
    assert masses(body) == [2.0, 0.0, 0.0, 0.0]
    with pytest.raises(ValueError, match="a body needs a moment of inertia of 1e-24 to 1e24"):
        body.set_mass(2.0, local_center=(0.1, 0.0))
    body.set_mass(2.0, inertia=0.5, local_center=(0.1, 0.0))
    assert masses(body) == pytest.approx([2.0, 0.5, 0.1, 0.0], rel=1e-6)
    body.reset_mass()
    assert masses(body) == [1.0, 0.0, 0.0, 0.0]


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"mass": 1e13}, "a mass must be 1e-12 to 1e12 kg"),  # more in refusal_test.cpp
        ({"inertia": math.nan}, "a body needs a moment of inertia"),
        ({"local_center": (0.0, math.inf)}, "a position must be finite and within 100 km"),
        ({"inertia": 1e-3, "local_center": (100.0, 0.0)}, "an inertia is too small for the mass"),
    ],
)
def test_wrong_values_are_refused_and_change_nothing(world, body, wrong, message):
    body.set_mass(4.0, inertia=0.7, local_center=(0.2, -0.1))
    before = world.save_state()

    with pytest.raises(ValueError, match=message):
        body.set_mass(**{"mass": 1.0, **wrong})

    assert world.save_state() == before


@pytest.mark.parametrize("kind", ["static", "kinematic"])
def test_only_a_dynamic_body_has_a_mass(world, kind):
    for body in (world.add_body(kind, (0, 0, 0)), world.add_layer([[0, 0, 1, 1]], 1)):
        for change in (lambda body=body: body.set_mass(1.0), body.reset_mass):
            with pytest.raises(ValueError, match="only a dynamic body has a mass"):
                change()


@pytest.mark.parametrize("density", [1e5, 1.0, 1e-6])
@pytest.mark.parametrize("place", [(0.0, 0.0), (300.0, -17.0), (1e3, 2e3)])
def test_states_have_heavy_and_light_bodies_to_the_bit(density, place):
    """Some have a moment of inertia that is larger than any value which a user may give."""

    def build(own: bool) -> tuple:
        world = _core.World()
        body = world.add_body("dynamic", (0.0, 0.0, 0.3))
        body.add_circle(place, 700.0, density=density)
        if own:
            body.set_mass(0.1 * body.mass, local_center=(0.3 * place[0], 5.0))
        body.velocity = (1.0, 0.2, 0.3)
        return world, body

    for owns in ((False, True), (True, False), (True, True), (False, False)):
        (first, one), (second, other) = map(build, owns)
        for _ in range(7):
            first.step(DT)
        saved = first.save_state()

        second.restore_state(saved)

        assert second.save_state() == saved
        for world, body in ((first, one), (second, other)):
            body.apply_force((1e9, 3e8), (2.0, 1e3))
            world.step(DT)
        assert first.save_state() == second.save_state()
        assert masses(one) == masses(other)
