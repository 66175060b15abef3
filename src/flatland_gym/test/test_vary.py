"""The argument and the option `vary`: numbers of model files that differ between episodes."""

import numpy as np
import pytest
from environments import assert_same, make, make_vector
from gymnasium.vector import SyncVectorEnv

from flatland2d import FlatlandError, UsageError
from flatland_gym.fleet import BatchFleet, SimulationFleet
from flatland_gym.multi_robot_vector_env import MultiRobotVectorEnv

pytestmark = pytest.mark.slow

COUNT = 3
RANGE, SPEED = "*/laser/range", "robot*/drive/linear_dynamics/velocity_limit"
VARY = {
    RANGE: (2.0, 8.0),
    SPEED: (0.4, 1.0),
    "robot*/drive/actuators/delay": (0.0, 0.2),
    "*/laser/noise_std_dev": (0.0, 0.1),
}
CROWDED = {"world": "discs", "time_limit": 2.0, "goal_distance": (0.4, 1.2), "beams": 16}
"""Episodes end often, and draw new values."""


def make_teams(count, **arguments):
    return MultiRobotVectorEnv(count, robots=2, **arguments)


def drive(env, steps=60, seed=3):
    """The results of a reset and some steps."""
    rng = np.random.default_rng(seed)
    actions = rng.uniform(-1.0, 2.0, (steps, *env.action_space.shape)).astype(np.float32)
    return [env.reset(seed=seed), *(env.step(each) for each in actions)]


@pytest.mark.parametrize("make_env", [make_vector, make_teams])
def test_episodes_are_those_of_simulations_whose_files_have_the_values(make_env, monkeypatch):
    found = []
    for fleet in (BatchFleet, SimulationFleet):
        monkeypatch.setattr(
            "flatland_gym.navigation.make_fleet", lambda *given, fleet=fleet: fleet(*given[:4])
        )
        env = make_env(COUNT, vary=VARY, **CROWDED)
        found.append(drive(env))
        states = env.save_states()
        found[-1] += [env.step(np.ones(env.action_space.shape, np.float32))]
        env.reset(options={"vary": {RANGE: 3.0}})
        env.load_states(states)
        found[-1] += [env.step(np.ones(env.action_space.shape, np.float32))]
        assert_same(found[-1][-2], found[-1][-1])
    assert_same(*found)
    values = np.concatenate([each[-1]["vary"].reshape(-1, len(VARY)) for each in found[0]])
    assert len(np.unique(values[:, 0])) > COUNT


def test_a_vector_environment_equals_single_ones():
    single = SyncVectorEnv([lambda: make(vary=VARY, **CROWDED)] * COUNT)
    assert_same(drive(single), drive(make_vector(COUNT, vary=VARY, **CROWDED)))


def test_values_are_drawn_within_the_ranges_or_given_for_each_environment():
    env = make_vector(64, world="empty_room", beams=8, vary={RANGE: (2.0, 8.0), SPEED: (0.4, 1.0)})
    _, infos = env.reset(seed=1)
    assert (infos["vary"].min(axis=0) >= [2.0, 0.4]).all()
    assert (infos["vary"].max(axis=0) <= [8.0, 1.0]).all()
    assert infos["vary"].std(axis=0).min() > 0.1
    env.unwrapped.reset_options = {"vary": {RANGE: (3.0, 4.0), SPEED: 0.5}}
    _, infos = env.reset()
    assert (abs(infos["vary"] - [3.5, 0.5]) <= [0.5, 0.0]).all()
    speeds = np.linspace(0.4, 1.0, 64)
    ends = np.column_stack([np.linspace(-3, 3, 64), np.zeros(64)])
    goals = ends + np.array([0.0, 3.0])
    env.unwrapped.reset_options = {"vary": {SPEED: speeds}, "start": ends, "goal": goals}
    _, infos = env.reset()
    assert np.array_equal(infos["vary"][:, 1], speeds)
    assert np.allclose(infos["pose"][:, :2], ends)
    assert np.array_equal(infos["goal"], goals)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"vary": {"*/laser/rang": 3}}, "did you mean"),
        ({"vary": {RANGE: 9}}, "within 2 to 8"),
        ({"vary": {RANGE: (3, 9)}}, "within 2 to 8"),
        ({"vary": {RANGE: (4, 3)}}, "least, greatest"),
        ({"vary": {RANGE: float("nan")}}, "least, greatest"),
        ({"vary": {RANGE: "3"}}, "or a number, found '3'"),
        ({"vary": {RANGE: [3, [4, 5]]}}, "least, greatest"),
        ({"vary": {RANGE: np.array([3.0, 9.0])}}, "within 2 to 8"),
        ({"vary": {RANGE: np.ones(3)}}, "for 2 environments, found 3"),
        ({"vary": 3}, "vary as a dict"),
        ({"start": np.zeros((3, 2))}, "for 2 environments, found 3"),
        ({"goal": np.zeros((2, 3))}, "goal as \\[x, y\\]"),
    ],
)
def test_wrong_options_are_refused(options, message):
    env = make_vector(2, world="empty_room", beams=8, vary={RANGE: (2.0, 8.0)})
    env.reset(seed=1)
    with pytest.raises(UsageError, match=message):
        env.reset(options=options)
    with pytest.raises(UsageError, match=message):
        env.unwrapped.reset_options = options


def test_wrong_arguments_are_refused():
    for vary in ({"robot/laser/rang": (1, 2)}, {"robot/laser/range": (0, 2)}, {"robot": (1, 2)}, 3):
        with pytest.raises(FlatlandError, match="vary"):
            make(world="empty_room", vary=vary)
