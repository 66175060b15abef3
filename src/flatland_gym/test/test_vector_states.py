"""States of vector environments: episodes go on from them, bit for bit."""

import numpy as np
import pytest
from environments import assert_same, make_vector

from flatland2d import FlatlandError
from flatland_gym.fleet import BatchFleet, SimulationFleet
from flatland_gym.multi_robot_vector_env import MultiRobotVectorEnv

pytestmark = pytest.mark.slow

COUNT = 4
CROWDED = {"time_limit": 2.0, "goal_distance": (0.4, 1.2), "beams": 16}
"""Episodes end often, and draw new ones."""


def make_teams(count, **arguments):
    return MultiRobotVectorEnv(count, robots=2, world="discs", **arguments)


@pytest.fixture(params=[BatchFleet, SimulationFleet])
def fleet(request, monkeypatch):
    monkeypatch.setattr(
        "flatland_gym.navigation.make_fleet", lambda *arguments: request.param(*arguments[:4])
    )


@pytest.fixture(params=[make_vector, make_teams])
def make_crowded(request, fleet):
    return lambda count=COUNT: request.param(count, **CROWDED)


def drive(env, steps, seed):
    """The results of some steps."""
    rng = np.random.default_rng(seed)
    actions = rng.uniform(-1.0, 2.0, (steps, *env.action_space.shape)).astype(np.float32)
    return [env.step(each) for each in actions]


def test_a_saved_state_continues_here_and_in_another_environment(make_crowded):
    env, other = make_crowded(), make_crowded()
    ahead = np.full(env.action_space.shape, 0.4, np.float32)
    env.reset(seed=3)
    drive(env, 13, 1)
    while isinstance(env, MultiRobotVectorEnv) and env.step(ahead)[-1]["present"].all():
        pass  # until a robot is done, and another one goes on
    states = env.save_states()
    expected = drive(env, 60, 2)
    assert any(terminated.any() or truncated.any() for _, _, terminated, truncated, _ in expected)

    env.load_states(states)
    assert_same(drive(env, 60, 2), expected)
    other.load_states(states)
    assert_same(drive(other, 60, 2), expected)


def test_a_mask_chooses_and_one_state_branches_into_many(make_crowded):
    env, wide = make_crowded(), make_crowded(7)
    env.reset(seed=3)
    drive(env, 5, 1)
    mask = np.arange(COUNT) == 2
    [state] = env.save_states(mask)
    before, *_ = drive(env, 1, 5)[0]

    after, infos = env.load_states(state, mask)
    assert np.array_equal(after[~mask], before[~mask])
    marks = infos["_goal"] if "_goal" in infos else infos["present"].any(axis=1)
    assert np.array_equal(marks, mask)

    observations, _ = wide.load_states(state)
    assert (observations == after[2]).all()


def test_states_with_another_number_of_robots_are_refused(fleet):
    env, single = make_teams(1), make_vector(1)
    for each in (env, single):
        each.reset(seed=3)
    with pytest.raises(FlatlandError, match="expected a state"):
        single.load_states(env.save_states())
    three = MultiRobotVectorEnv(1, robots=3, world="discs")
    with pytest.raises(FlatlandError, match="expected states with 3 robots, found 2"):
        three.load_states(env.save_states())


def test_wrong_states_are_refused(make_crowded):
    env = make_crowded()
    with pytest.raises(FlatlandError, match="expected reset before save_states"):
        env.save_states()
    env.reset(seed=3)
    states = env.save_states()
    broken = states[0].replace(b'"steps"', b'"stops"')
    for wrong in (states[:2], b"", b"{}", broken, None, 5):
        with pytest.raises(FlatlandError, match="expected"):
            env.load_states(wrong)
    with pytest.raises(FlatlandError, match="expected mask as an array of 4 booleans"):
        env.load_states(states[0], [True])
    assert env.save_states() == states
