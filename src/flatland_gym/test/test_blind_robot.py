"""A robot that ignores people collides: results in these worlds mean something."""

import numpy as np
import pytest

pytest.importorskip("gymnasium")

from flatland_gym import NavigationVectorEnv
from flatland_gym.evaluation import StraightDriver, evaluate


@pytest.mark.slow
@pytest.mark.parametrize("world", ["corridor", "crossing", "circle_crossing", "intersection"])
def test_a_blind_robot_collides_in_at_least_half_of_the_episodes(world):
    collisions = evaluate(StraightDriver(64), seeds=range(200), world=world, beams=64).collision

    assert collisions.mean() >= 0.5


def test_people_do_not_walk_into_a_robot_that_stands():
    env = NavigationVectorEnv(60, world="corridor", beams=8, collision_ends=False)
    env.reset(seed=1)
    hit = np.zeros(60, bool)
    for _ in range(500):
        hit |= env.step(np.zeros((60, 2)))[-1]["collision"]

    assert hit.mean() < 0.05


def test_without_people_a_blind_robot_arrives():
    found = evaluate(
        StraightDriver(64), seeds=range(2), world="crossing", beams=64, params={"/people": 0}
    )

    assert found.success.all()


def test_a_scenes_start_and_goal_are_used_unless_options_differ():
    import gymnasium

    import flatland_gym  # noqa: F401

    env = gymnasium.make("flatland/Navigation-v0", world="crossing")
    _, info = env.reset(seed=3)
    assert info["pose"] == pytest.approx((-5.0, 0.0, 0.0))
    assert info["goal"] == pytest.approx((5.0, 0.0))
    _, info = env.reset(options={"goal": [5, 4]})
    assert info["goal"] == pytest.approx((5.0, 4.0))
