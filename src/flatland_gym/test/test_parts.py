"""Observations of parts that a user chooses, and privileged ones."""

import numpy as np
import pytest

pytest.importorskip("gymnasium")

from environments import assert_same, make, make_vector
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import SyncVectorEnv

from flatland2d import UsageError, world_content
from flatland_gym import SCENARIOS, MapCrop, ObservationPart
from flatland_gym.evaluation import StraightDriver, evaluate
from flatland_gym.train import Mirror

CORRIDOR = {"world": "corridor", "beams": 8, "neighbors": 2}


def to_goal(now):
    return np.hypot(*(now.goals - now.poses[:, :2]).T)


def nearest_model(now):
    offsets = now.models.poses[..., :2] - now.poses[:, None, :2]
    return np.hypot(offsets[..., 0], offsets[..., 1]).min(axis=1, keepdims=True)


PARTS = ["velocity", "goal", MapCrop(6, 0.5), to_goal, ObservationPart(nearest_model, (1,), 0.0)]


def test_chosen_parts_equal_those_of_the_default_observation():
    plain, chosen = (make(**CORRIDOR, observation=p) for p in (None, ["goal", "neighbors"]))

    everything, _ = plain.reset(seed=3)
    found, _ = chosen.reset(seed=3)

    assert_same(found, np.concatenate([everything[8:11], everything[13:]]))
    assert_same(chosen.observation_space.low[:3], plain.observation_space.low[8:11])


def test_parts_in_a_dict_and_functions():
    env = make(**CORRIDOR, observation=PARTS, flatten=False)

    observation, info = env.reset(seed=3)

    assert list(observation) == ["velocity", "goal", "map", "to_goal", "nearest_model"]
    assert observation["map"].shape == (6, 6)
    assert observation["to_goal"] == np.float32(info["distance"])
    assert env.observation_space["nearest_model"].low == [0.0]
    observation, *_, info = env.step(env.action_space.high)
    assert observation["to_goal"] == np.float32(info["distance"])
    check_env(env)


def test_the_map_is_in_the_robots_frame():
    world = world_content(SCENARIOS["empty_room"].world)
    world["layers"] = [{"name": "map", "map": {"segments": [[-4, -3, -4, 3], [-4, 1.5, 4, 1.5]]}}]
    env = make(world=world, observation=MapCrop(4, 1.0), flatten=False)

    def seen(*start):
        options = {"start": list(start), "goal": [-1.0, -1.0]}
        return env.reset(options=options)[0]["map"]

    ahead = seen(0.0, 0.0, 0.0)  # rows are -1.5, -0.5, 0.5, 1.5 m ahead, columns as far to the left
    assert ahead.tolist() == [[0, 0, 0, 1]] * 4
    turned = seen(0.0, 0.0, np.pi / 2)
    assert turned.tolist() == [[0] * 4] * 3 + [[1] * 4]
    assert seen(-2.1, -2.0, np.pi)[3].any()  # the left wall, 1.9 m ahead


@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
def test_vector_environments_equal_single_ones_to_the_bit(mode):
    arguments = {
        **CORRIDOR, "observation": [*PARTS, "models"], "privileged": ["pose", to_goal],
        "time_limit": 0.5,
    }  # fmt: skip
    envs = make_vector(3, autoreset_mode=mode, **arguments)
    others = SyncVectorEnv([lambda: make(**arguments)] * 3, autoreset_mode=mode)

    assert_same(envs.reset(seed=4), others.reset(seed=4))
    envs.action_space.seed(0)
    for _ in range(12):
        actions = envs.action_space.sample()
        assert_same(envs.step(actions), others.step(actions))


def test_privileged_parts_are_in_the_info_of_resets_and_steps():
    arguments = {**CORRIDOR, "neighbors": 0}
    env, plain = make(**arguments, privileged=["pose", to_goal]), make(**arguments)

    observation, info = env.reset(seed=3)

    assert_same(observation, plain.reset(seed=3)[0])
    x, y, yaw = info["pose"]
    expected = [x, y, np.cos(yaw), np.sin(yaw), info["distance"]]
    np.testing.assert_array_equal(info["privileged"], np.float32(expected))
    *_, info = env.step(env.action_space.high)
    assert info["privileged"][4] == np.float32(info["distance"])


def test_true_models_are_seen_through_walls_and_without_noise():
    arguments = {**CORRIDOR, "neighbor_range": 0.5, "neighbor_noise": 0.2}
    env = make(**arguments, privileged="models")

    _, info = env.reset(seed=3)

    rows = info["privileged"].reshape(-1, 6)
    assert (rows[:, 0] > 0.0).all()  # all of them, however far they are
    assert (np.diff(rows[:, 0]) <= 0.0).all()


def test_parts_of_a_team_are_given_for_each_robot():
    pytest.importorskip("pettingzoo")
    from flatland_gym.multi_robot_env import MultiRobotEnv
    from flatland_gym.multi_robot_vector_env import MultiRobotVectorEnv

    arguments = {"robots": 2, "world": "crossing", "beams": 8, "privileged": "pose"}
    arguments["observation"] = ["goal", to_goal]
    team, many = MultiRobotEnv(**arguments), MultiRobotVectorEnv(2, **arguments)

    observations, infos = team.reset(seed=5)
    rows, all_infos = many.reset(seed=5)

    for k, agent in enumerate(team.agents):
        assert observations[agent].shape == team.observation_space(agent).shape == (4,)
        assert_same(rows[0, k], observations[agent])
        assert_same(all_infos["privileged"][0, k], infos[agent]["privileged"])


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ("rangs", "found 'rangs' \\(did you mean \"ranges\"\\?\\)"),
        ([], "one at least in a sequence, found"),
        (["goal", "goal"], 'different names, found "goal" twice'),
        ([7], "found 7"),
        ("neighbors", "expected neighbors above 0"),
        (lambda now: "far", 'from the observation "<lambda>"'),
        (
            ObservationPart(to_goal, (2,), name="mine"),
            r"shape \(1, 2\) from the observation \"mine\"",
        ),
        (MapCrop(8, 1e-3), "a MapCrop may have larger ones"),
    ],
)
@pytest.mark.parametrize("name", ["observation", "privileged"])
def test_wrong_parts_are_refused(name, value, message):
    with pytest.raises(UsageError, match=message):
        make(world="corridor", beams=8, **{name: value}).reset(seed=0)


@pytest.mark.parametrize("arguments", [(0, 0.1), (8, 0.0), (8, float("nan")), ("8", 0.1)])
def test_wrong_crops_are_refused(arguments):
    with pytest.raises(UsageError, match=r"of a MapCrop|expected a resolution"):
        MapCrop(*arguments)


def test_evaluate_and_mirror_refuse_custom_observations():
    arguments = {"world": "corridor", "beams": 8, "observation": ["goal", "ranges"]}
    with pytest.raises(UsageError, match="expected no argument observation"):
        evaluate(StraightDriver(8), [0], **arguments)
    with pytest.raises(UsageError, match="expected no argument observation"):
        Mirror.of(make(**arguments).navigation)
