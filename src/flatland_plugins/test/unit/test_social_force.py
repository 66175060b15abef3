"""The social force model: each term against its formula."""

import cmath
import math

import numpy as np
import pytest

from flatland_plugins.social_force import Others, SocialForce, directions, discs_apart, limit

A, B, TAU = 25.0, 0.08, 0.5  # 2000 N on 80 kg, 8 cm, half a second: Helbing et al., 2000


@pytest.mark.parametrize("dt", [0.005, 0.05, 0.3])
def test_a_velocity_relaxes_to_the_desired_one_within_the_relaxation_time(dt):
    velocity, desired = np.zeros((1, 2)), np.array([[0.8, -1.0]])

    for update in range(1, 20):
        velocity = SocialForce().relax(velocity, desired, np.zeros((1, 2)), dt)

        left_over = math.exp(-update * dt / TAU)
        assert velocity == pytest.approx((1.0 - left_over) * desired, abs=1e-12)


def test_under_a_constant_acceleration_a_velocity_settles_where_both_forces_are_equal():
    velocity, desired = np.array([[1.0, 2.0]]), np.array([[1.0, 0.0]])

    settled = SocialForce().relax(velocity, desired, np.array([[-1.5, 0.4]]), 20.0)

    assert settled == pytest.approx(np.array([[1.0 - 1.5 * TAU, 0.4 * TAU]]), abs=1e-9)


@pytest.mark.parametrize("gap", [0.0, 0.05, 0.2, 0.5])
def test_two_persons_repel_each_other_exponentially(gap):
    distance = 0.3 + 0.25 + gap
    bearing = 0.7
    points = np.array(
        [[1.0, 2.0], [1.0 + distance * math.cos(bearing), 2.0 + distance * math.sin(bearing)]]
    )

    pushes = SocialForce().repel(discs_apart(points, np.array([0.3, 0.25])))

    strength = A * math.exp((0.3 + 0.25 - distance) / B)
    away = -strength * np.array([math.cos(bearing), math.sin(bearing)])
    assert pushes[0] == pytest.approx(away, rel=1e-9)
    assert pushes[1] == pytest.approx(-away, rel=1e-9)


def test_the_pushes_of_several_add_up():
    points = np.array([[0.0, 0.0], [0.8, 0.0], [0.0, -0.9]])

    pushes = SocialForce().repel(discs_apart(points, np.full(3, 0.3)))

    expected = [-A * math.exp((0.6 - 0.8) / B), A * math.exp((0.6 - 0.9) / B)]
    assert pushes[0] == pytest.approx(expected, rel=1e-9)


def test_who_overlaps_is_repelled_as_by_a_touch():
    points = np.array([[0.0, 0.0], [0.1, 0.0], [0.1, 0.0]])

    pushes = SocialForce().repel(discs_apart(points, np.full(3, 0.3)))

    # Those two at one place have no direction away from each other.
    assert pushes == pytest.approx(np.array([[-2 * A, 0.0], [A, 0.0], [A, 0.0]]))


def evasion(gap: float, bearing: float, velocity: complex, epsilon: float = 0.005) -> complex:
    """The formula of Moussaid et al., 2009, in the complex plane.

    f = -A exp(-d / B) (exp(-(n' B theta)^2) t + sign(theta) exp(-(n B theta)^2) n) with the
    interaction vector D = lambda w + e, its direction t and normal n, B = gamma |D|, and theta from
    t to e; A = 4.5 m/s^2, gamma = 0.35 m, n = 2, n' = 3, lambda = 2 s/m.
    """
    direction = cmath.rect(1.0, bearing)
    interaction = 2.0 * velocity + direction
    reach = 0.35 * abs(interaction)
    theta = cmath.phase(direction / interaction) + epsilon * reach
    slower = math.exp(-((3.0 * reach * theta) ** 2))
    aside = math.copysign(math.exp(-((2.0 * reach * theta) ** 2)), theta)
    strength = 4.5 * math.exp(-gap / reach)
    return -strength * complex(slower, aside) * interaction / abs(interaction)


def evade(gap: float, bearing: float, velocity: complex, **constants: float) -> complex:
    """The same from the code: of another person at a gap and a bearing."""
    other = Others(np.array([[gap]]), -np.array([[[math.cos(bearing), math.sin(bearing)]]]))
    relative_velocity = np.array([[[velocity.real, velocity.imag]]])
    return complex(*SocialForce(**constants).evade(other, relative_velocity)[0])


@pytest.mark.parametrize("gap", [0.0, 0.5, 3.0])
@pytest.mark.parametrize("bearing", [0.0, 0.3, -0.3, 2.0, math.pi])
@pytest.mark.parametrize("velocity", [1.3 + 0j, 2.6 + 0.2j, -0.5 + 1j, 0j])
def test_people_evade_as_it_was_measured(gap, bearing, velocity):
    assert evade(gap, bearing, velocity) == pytest.approx(
        evasion(gap, bearing, velocity), rel=1e-9, abs=1e-12
    )


@pytest.mark.parametrize(("preference", "side"), [(0.005, -1.0), (-0.005, 1.0)])
def test_who_is_straight_ahead_is_evaded_to_the_preferred_side(preference, side):
    push = evade(1.0, 0.0, 1.3 + 0j, side_preference=preference)

    assert push == pytest.approx(evasion(1.0, 0.0, 1.3 + 0j, preference), rel=1e-9)
    assert push.imag * side > 1.0


def test_evasions_add_up_and_oneself_is_not_evaded():
    points = np.array([[0.0, 0.0], [2.0, 0.1], [3.0, -0.5]])
    velocities = np.array([[1.3, 0.0], [-1.0, 0.0], [0.0, 0.5]])
    gaps = discs_apart(points, np.full(3, 0.3))

    pushes = SocialForce().evade(gaps, velocities[:, np.newaxis] - velocities)

    expected = 0j
    for (x, y), (vx, vy) in zip(points[1:], velocities[1:]):
        gap, bearing = math.hypot(x, y) - 0.6, math.atan2(y, x)
        expected += evasion(gap, bearing, complex(1.3 - vx, -vy))
    assert complex(*pushes[0]) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("dt", [0.01, 0.2])
def test_noise_scatters_velocities_as_told_however_often_it_comes(dt):
    force = SocialForce(noise=0.1)
    rng = np.random.default_rng(1)
    velocities, nothing = np.zeros((5000, 2)), np.zeros((5000, 2))

    for _ in range(round(3.0 / dt)):
        velocities = force.relax(velocities, nothing, nothing, dt)
        velocities += force.scatter(rng.standard_normal(velocities.shape), dt)

    # Chi-squared: n squares of standard normals are n +- sqrt(2 n).
    squares = ((velocities / 0.1) ** 2).sum()
    assert abs(squares - velocities.size) < 4 * math.sqrt(2 * velocities.size)


def test_speeds_are_limited_and_directions_kept():
    velocities = np.array([[3.0, 4.0], [0.3, -0.4], [0.0, 0.0]])

    limited = limit(velocities, np.array([2.0, 2.0, 0.0]))

    assert limited == pytest.approx(np.array([[1.2, 1.6], [0.3, -0.4], [0.0, 0.0]]))


def test_a_direction_has_length_one_and_none_has_none():
    unit, lengths = directions(np.array([[3.0, 4.0], [0.0, 0.0]]))

    assert unit == pytest.approx(np.array([[0.6, 0.8], [0.0, 0.0]]))
    assert lengths == pytest.approx(np.array([5.0, 0.0]))
