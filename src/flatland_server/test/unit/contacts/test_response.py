"""The forces between two bodies that touch, and their changes by `pre_solve`."""

import math

import pytest
from contacts.room import DT, MASS, RADIUS, SQUARE, actions, called_hooks


@pytest.mark.parametrize("is_driven", [False, True])
@pytest.mark.parametrize("speed", [1.0, 20.0, 100.0])
def test_a_body_passes_through_a_wall_if_its_contact_is_disabled(room, speed, is_driven):
    actions["pre_solve"] = lambda _, contact, __: contact.set_enabled(False)
    ball = room.put("ball", (0.85, 0.0, 0.0), (speed, 0.0, 0.0), "Listener")
    if is_driven:
        ball.base.physics_body.add_drive().command(speed, 0.0, 0.0)

    room.run(0.5)

    assert "pre_solve" in called_hooks()
    assert "post_solve" not in called_hooks()
    assert ball.pose.x == pytest.approx(0.85 + 0.5 * speed, rel=1e-5)
    assert ball.base.physics_body.velocity == pytest.approx((speed, 0.0, 0.0))


def test_models_pass_through_each_other_if_a_contact_is_disabled(room):
    def let_pass(plugin, contact, _):
        contact.set_enabled(plugin.model.name != "ghost" and contact.enabled)

    actions["pre_solve"] = let_pass
    ghost = room.put("ghost", (0.0, 0.0, 0.0), (0.5, 0.0, 0.0), "Listener")
    other = room.put("other", (0.3, 0.0, 0.0), (0.0, 0.0, 0.0), "Listener")

    room.run(1.0)

    assert ghost.pose == pytest.approx((0.5, 0.0, 0.0), abs=1e-5)
    assert other.pose == pytest.approx((0.3, 0.0, 0.0), abs=1e-6)


def test_a_contact_is_disabled_for_one_step_only(room):
    actions["pre_solve"] = lambda _, contact, __: contact.set_enabled(False)
    ball = room.put("ball", (0.85, 0.0, 0.0), (1.0, 0.0, 0.0), "Listener")
    room.run(0.1)
    assert ball.pose.x == pytest.approx(0.95)

    del actions["pre_solve"]
    room.run(0.5)

    assert ball.pose.x < 0.91  # pushed out again


@pytest.mark.parametrize("hook", ["begin_contact", "end_contact", "post_solve"])
def test_a_contact_cannot_be_disabled_in_another_hook(room, hook, caplog):
    actions[hook] = lambda _, contact, *__: contact.set_enabled(False)
    ball = room.put("ball", (0.85, 0.0, 0.0), (2.0, 0.0, 0.0), "Listener")
    room.run(0.1)
    ball.base.physics_body.velocity = (-1.0, 0.0, 0.0)
    room.run(0.1)

    [failure] = room.world.plugin_failures
    assert failure.reason == (
        f"{hook}: RuntimeError: a contact can be enabled or disabled only in pre_solve"
    )


@pytest.mark.parametrize(("restitution", "factor"), [(0.0, 1.0), (0.5, 1.5), (1.0, 2.0)])
def test_collision_impulses_equal_the_change_of_momentum(room, restitution, factor):
    impulses = []
    actions["post_solve"] = lambda _, __, impulse: impulses.extend(impulse.normal_impulses)
    disc = f"{{type: circle, radius: {RADIUS}, density: 10, restitution: {restitution}}}"
    ball = room.put("ball", (0.8, 0.0, 0.0), (2.0, 0.0, 0.0), "Listener", disc)

    room.run(0.2)

    assert ball.base.physics_body.mass == pytest.approx(MASS)
    assert ball.base.physics_body.velocity[0] == pytest.approx(-2.0 * restitution, abs=1e-5)
    assert sum(impulses) == pytest.approx(factor * MASS * 2.0, rel=1e-5)


def test_the_old_manifold_is_that_of_the_previous_step(room):
    force = 3.0
    solved, old = [], []
    actions["before_physics_step"] = lambda plugin, _: plugin.model.base.physics_body.apply_force(
        (force, 0.0)
    )
    actions["pre_solve"] = lambda _, __, manifold: old.append(manifold)
    actions["post_solve"] = lambda _, __, impulse: solved.append(impulse)
    room.put("square", (0.79, 0.0, 0.0), plugins="Listener", footprints=SQUARE)

    room.run(1.0)

    assert old[0].local_points == []
    assert old[0].normal_impulses == []
    assert len(old[-1].local_points) == 2
    assert sum(solved[-1].normal_impulses) == pytest.approx(force * DT, rel=1e-3)
    assert sum(old[-1].normal_impulses) == pytest.approx(force * DT, rel=1e-3)
    assert old[-1].tangent_impulses == pytest.approx([0.0, 0.0], abs=1e-6)


def test_friction_set_in_pre_solve_brakes_a_sliding_body(room):
    force, friction = 20.0, 0.5
    mass = 10.0 * 0.4**2
    square = room.put("square", (0.795, -3.0, 0.0), (0.0, 0.0, 0.0), "Listener", SQUARE)
    body = square.base.physics_body
    actions["before_physics_step"] = lambda *_: body.apply_force((force, 0.0))
    room.run(0.1)
    body.velocity = (0.0, 4.0, 0.0)
    room.run(0.1)
    assert body.velocity[1] == pytest.approx(4.0, abs=1e-4)  # footprints have no friction

    def rub(_, contact, __):
        contact.friction = friction

    actions["pre_solve"] = rub
    room.run(0.4)

    assert body.velocity[1] == pytest.approx(4.0 - 0.4 * friction * force / mass, rel=0.01)


def test_restitution_set_in_pre_solve_makes_a_body_bounce(room):
    def bounce(_, contact, __):
        contact.restitution = 0.75

    actions["pre_solve"] = bounce
    ball = room.put("ball", (0.8, 0.0, 0.0), (2.0, 0.0, 0.0), "Listener")

    room.run(0.2)

    assert ball.base.physics_body.velocity[0] == pytest.approx(-1.5, rel=1e-5)


@pytest.mark.parametrize("speed", [0.3, -0.3])
def test_tangent_speed_of_a_wall_moves_a_body_along_it(room, speed):
    directions = []

    def convey(plugin, contact, _):
        contact.friction = 1.0
        contact.tangent_speed = speed
        # In Box2D: the velocity of b relative to a, along the normal turned clockwise by 90 deg.
        side = 1.0 if contact.fixture_b.body == plugin.model.base.physics_body else -1.0
        directions.append(-side * contact.normal[0])

    actions["pre_solve"] = convey
    square = room.put("square", (0.795, 0.0, 0.0), (0.0, 0.0, 0.0), "Listener", SQUARE)
    body = square.base.physics_body
    actions["before_physics_step"] = lambda *_: body.apply_force((10.0, 0.0))

    room.run(0.5)

    assert body.velocity == pytest.approx((0.0, directions[-1] * speed, 0.0), abs=1e-3)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *((name, math.nan) for name in ("friction", "restitution", "tangent_speed")),
        *((name, -math.inf) for name in ("friction", "restitution", "tangent_speed")),
        ("friction", -0.1),
        ("restitution", -0.1),
    ],
)
def test_a_contact_refuses_non_finite_and_negative_values(room, name, value):
    refusals = []

    def spoil(_, contact, __):
        before = getattr(contact, name)
        try:
            setattr(contact, name, value)
        except ValueError as error:
            refusals.append(str(error))
        assert getattr(contact, name) == before

    actions["pre_solve"] = spoil
    room.put("ball", (0.85, 0.0, 0.0), (2.0, 0.0, 0.0), "Listener")

    room.run(0.1)

    assert room.world.plugin_failures == []
    assert "must be finite" in refusals[0] or "must be" in refusals[0]
