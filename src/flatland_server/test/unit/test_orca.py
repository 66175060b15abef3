"""ORCA: the core's velocities against hand-computed ones, and against RVO2 where pyrvo is."""

import math
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


def test_of_two_who_walk_towards_each_other_each_makes_half_of_the_change():
    # 4 m apart, radii of 0.5 m, 2 s: the cone is cut off by a circle about (2, 0) of radius 0.5.
    # The relative velocity (1.8, 0) leaves it at (1.5, 0).
    other = [4.0, 0.0, -0.9, 0.0, 1.0, 0.5]

    assert choose((0.9, 0.0), (0.9, 0.0), [other]) == pytest.approx((0.75, 0.0), abs=1e-12)


def test_who_overlaps_another_is_apart_after_a_step():
    other = [0.9, 0.0, 0.0, 0.0, 1.0, 1.0]

    assert choose((0.0, 0.0), (0.0, 0.0), [other], dt=0.5) == pytest.approx((-0.2, 0.0))


def test_beyond_the_cut_off_the_leg_of_the_cone_counts():
    # 5 m ahead with radii of 3 m: the legs are at asin(3/5), along (4, 3) / 5 and (4, -3) / 5.
    other = [5.0, 0.0, 0.0, 0.0, 3.0, 1.0]

    chosen = choose((10.0, 1.0), (10.0, 1.0), [other], most=20.0)

    along = np.array([0.8, 0.6])
    assert chosen == pytest.approx((along @ (10.0, 1.0)) * along, abs=1e-12)


def test_a_wall_is_approached_so_slowly_that_it_takes_its_horizon():
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


@pytest.mark.parametrize("crowding", [3.0, 5.0], ids=["crowded", "sparse"])
def test_equal_to_rvo2(crowding):
    pyrvo = pytest.importorskip("pyrvo")
    rng = np.random.default_rng(1)
    for _ in range(100):
        count, horizon, dt, most = 11, 2.0, 0.1, 1.5
        points = rng.uniform(-crowding, crowding, (count, 2))
        velocities, preferred = rng.uniform(-1, 1, (2, count, 2))
        radii = rng.uniform(0.1, 0.3, count)
        simulator = pyrvo.RVOSimulator(dt, 100.0, count, horizon, 1.0, 0.2, most)
        for k in range(count):
            simulator.add_agent(points[k].tolist())
            simulator.set_agent_velocity(k, velocities[k].tolist())
            simulator.set_agent_pref_velocity(k, preferred[k].tolist())
            simulator.set_agent_radius(k, radii[k])
        simulator.do_step()
        for k in range(count):
            others = np.argsort(((points - points[k]) ** 2).sum(axis=1))[1:]
            rows = [
                [*(points[j] - points[k]), *velocities[j], radii[k] + radii[j], 0.5] for j in others
            ]
            chosen = choose(velocities[k], preferred[k], rows, horizon=horizon, dt=dt, most=most)
            found = simulator.get_agent_velocity(k)
            assert chosen == pytest.approx((found.x, found.y), abs=1e-5)
