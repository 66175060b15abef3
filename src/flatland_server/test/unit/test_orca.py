"""ORCA: the core's velocities against hand-computed ones, and against those of RVO2."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flatland_server._core import orca_velocity

NOBODY, NO_WALLS = np.empty((0, 6)), np.empty((0, 3))


def choose(velocity: Any, preferred: Any, neighbors: Any = NOBODY, walls: Any = NO_WALLS, **more):
    numbers = {"most": 2.0, "horizon": 2.0, "wall_horizon": 1.0, "dt": 0.1, **more}
    neighbors = np.array(neighbors, float).reshape(-1, 6)
    return orca_velocity(velocity, preferred, neighbors, np.array(walls, float), **numbers)


def test_alone_the_preferred_velocity_up_to_the_largest_speed():
    assert choose((0, 0), (1.0, -0.5)) == (1.0, -0.5)
    assert choose((0, 0), (3.0, 4.0), most=1.0) == pytest.approx((0.6, 0.8))


def test_two_people_head_on_each_make_half_of_the_change():
    # 4 m apart, radii of 0.5 m, 2 s: the cone is cut off by a circle about (2, 0) of radius 0.5.
    # The relative velocity (1.8, 0) leaves it at (1.5, 0).
    other = [4.0, 0.0, -0.9, 0.0, 1.0, 0.5]

    assert choose((0.9, 0.0), (0.9, 0.0), [other]) == pytest.approx((0.75, 0.0), abs=1e-12)


def test_overlapping_people_are_apart_after_a_step():
    other = [0.9, 0.0, 0.0, 0.0, 1.0, 1.0]

    assert choose((0.0, 0.0), (0.0, 0.0), [other], dt=0.5) == pytest.approx((-0.2, 0.0))


def test_beyond_the_cut_off_the_leg_of_the_cone_counts():
    # 5 m ahead with radii of 3 m: the legs are at asin(3/5), along (4, 3) / 5 and (4, -3) / 5.
    other = [5.0, 0.0, 0.0, 0.0, 3.0, 1.0]

    chosen = choose((10.0, 1.0), (10.0, 1.0), [other], most=20.0)

    along = np.array([0.8, 0.6])
    assert chosen == pytest.approx((along @ (10.0, 1.0)) * along, abs=1e-12)


def test_a_wall_is_reached_no_sooner_than_its_time_horizon():
    wall = [0.6, -1.0, 0.0]  # on the right
    assert choose((1, 0), (1.5, 0.3), walls=[wall], wall_horizon=2.0) == pytest.approx((0.3, 0.3))


def test_a_wall_is_kept_to_even_if_neighbours_leave_no_velocity():
    walls = [[0.0, -1.0, 0.0]]
    pushing = [[-0.3, 0.0, 0.0, 0.0, 1.0, 1.0]]  # overlaps: asks for 7 m/s to the right

    assert choose((0, 0), (0, 0), pushing, walls)[0] <= 1e-9


def test_wrong_arguments_raise_value_errors():
    with pytest.raises(ValueError, match=r"neighbors of shape \(n, 6\)"):
        orca_velocity(
            (0, 0), (0, 0), np.empty((1, 5)), NO_WALLS, most=1, horizon=1, wall_horizon=1, dt=1
        )
    with pytest.raises(ValueError, match="above zero"):
        choose((0, 0), (0, 0), horizon=0.0)
    with pytest.raises(ValueError, match="above zero"):
        choose((0, 0), (0, 0), dt=math.nan)


SCENES, AGENTS, HORIZON, DT, MOST = 100, 11, 2.0, 0.1, 1.5
CROWDING = {"crowded": 3.0, "sparse": 5.0}
RECORDED = Path(__file__).with_name("rvo2.npz")
"""RVO2's velocities, shape (scenes, agents, 2): pyrvo needs packages that tests do not install."""


def scenes(kind):
    """Points, velocities, preferred velocities and radii of agents."""
    rng, half = np.random.default_rng(1), CROWDING[kind]
    for _ in range(SCENES):
        points = rng.uniform(-half, half, (AGENTS, 2))
        velocities, preferred = rng.uniform(-1, 1, (2, AGENTS, 2))
        yield points, velocities, preferred, rng.uniform(0.1, 0.3, AGENTS)


@pytest.mark.parametrize("kind", CROWDING)
def test_equal_to_rvo2(kind):
    with np.load(RECORDED) as recorded:
        expected = recorded[kind]
    found = []
    for points, velocities, preferred, radii in scenes(kind):
        for k in range(AGENTS):
            others = np.argsort(((points - points[k]) ** 2).sum(axis=1))[1:]
            rows = [
                [*(points[j] - points[k]), *velocities[j], radii[k] + radii[j], 0.5] for j in others
            ]
            found.append(
                choose(velocities[k], preferred[k], rows, horizon=HORIZON, dt=DT, most=MOST)
            )

    assert found == pytest.approx(expected.reshape(-1, 2), abs=1e-5)


@pytest.mark.parametrize("kind", CROWDING)
def test_the_recorded_velocities_are_those_of_rvo2(kind):
    pytest.importorskip("pyrvo")
    with np.load(RECORDED) as recorded:
        assert rvo2_velocities(kind) == pytest.approx(recorded[kind], abs=1e-6)


def rvo2_velocities(kind):
    """The velocities that RVO2 chooses, by its binding pyrvo 0.4.3."""
    import pyrvo

    found = []
    for points, velocities, preferred, radii in scenes(kind):
        simulator = pyrvo.RVOSimulator(DT, 100.0, AGENTS, HORIZON, 1.0, 0.2, MOST)
        for k in range(AGENTS):
            simulator.add_agent(points[k].tolist())
            simulator.set_agent_velocity(k, velocities[k].tolist())
            simulator.set_agent_pref_velocity(k, preferred[k].tolist())
            simulator.set_agent_radius(k, radii[k])
        simulator.do_step()
        chosen = (simulator.get_agent_velocity(k) for k in range(AGENTS))
        found.append([(velocity.x, velocity.y) for velocity in chosen])
    return np.array(found)


if __name__ == "__main__":  # with pyrvo
    np.savez_compressed(
        RECORDED, **{kind: rvo2_velocities(kind).astype(np.float32) for kind in CROWDING}
    )
