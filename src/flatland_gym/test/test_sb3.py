"""The environments of Stable-Baselines3, compared with its DummyVecEnv of single ones."""

import pickle

import numpy as np
import pytest
from environments import assert_same, make

from flatland2d import UsageError, world_content

# src/flatland2d/test/pip runs this file in an environment with the extra `sb3`.
pytest.importorskip("stable_baselines3")

import torch
from stable_baselines3 import PPO, SAC
from stable_baselines3.common.vec_env import DummyVecEnv, VecFrameStack, VecMonitor, VecNormalize

from flatland_gym.multi_robot_vector_env import MultiRobotVectorEnv
from flatland_gym.sb3 import MultiRobotVecEnv, NavigationVecEnv
from flatland_gym.sb3_training import ScaledActions, mirrored, policy_of
from flatland_gym.train import Mirror

ARGUMENTS = {"world": "discs", "time_limit": 2.0, "goal_distance": (0.5, 2.0), "beams": 16}


def drive(env, steps):
    env.seed(3)
    results = [env.reset()]
    rng = np.random.default_rng(1)
    for _ in range(steps):
        actions = rng.uniform(-2, 2, (env.num_envs, 2)).astype(np.float32)
        actions[:, 0] = np.abs(actions[:, 0])
        results.append((*env.step(actions), list(env.reset_infos)))
    env.close()
    return results


@pytest.mark.parametrize("flatten", [True, False])
def test_a_vector_environment_equals_single_ones(flatten):
    arguments = {**ARGUMENTS, "flatten": flatten}
    expected = drive(DummyVecEnv([lambda: make(**arguments)] * 5), 120)
    found = drive(NavigationVecEnv(5, **arguments), 120)

    assert_same([dict(each) if isinstance(each, dict) else each for each in expected], found)
    infos = [info for result in found[1:] for info in result[3]]
    assert any("terminal_observation" in info for info in infos)
    assert any(info["TimeLimit.truncated"] for info in infos)


@pytest.mark.parametrize("flatten", [True, False])
def test_teams_are_rows_that_end_together(flatten):
    arguments = {**ARGUMENTS, "flatten": flatten}
    teams = MultiRobotVectorEnv(3, 2, autoreset_mode="SameStep", **arguments)
    env = MultiRobotVecEnv(3, 2, **arguments)
    env.seed(3)

    def rows(values):
        if isinstance(values, dict):
            return {name: rows(each) for name, each in values.items()}
        return values.reshape(6, *values.shape[2:])

    assert_same(env.reset(), rows(teams.reset(seed=3)[0]))
    rng, left, truncations = np.random.default_rng(1), 0, 0
    for _ in range(120):
        actions = rng.uniform(0, 1, (3, 2, 2)).astype(np.float32)
        observations, rewards, _, truncated, found = teams.step(actions)
        result = env.step(actions.reshape(6, 2))
        assert_same(result[0], rows(observations))
        assert_same(result[1], rewards.ravel().astype(np.float32))
        ended = found.get("_final_obs", np.zeros(3, bool))
        assert_same(result[2], np.repeat(ended, 2))
        left += (~found["present"]).sum()
        for index, info in enumerate(result[3]):
            assert info["TimeLimit.truncated"] == truncated.flat[index]
            source, place = found, divmod(index, 2)
            if ended[place[0]]:
                source = found["final_info"]
                last = found["final_obs"][place[0]]
                last = {k: v[place[1]] for k, v in last.items()} if not flatten else last[place[1]]
                assert_same(info["terminal_observation"], last)
                truncations += info["TimeLimit.truncated"]
            assert info["distance"] == source["distance"][place]
    assert left > 0  # robots that were done before others
    assert truncations > 0
    with pytest.raises(UsageError, match="expected actions of shape"):
        env.step(actions[0])


def test_one_policy_learns_to_drive_a_team():
    env = VecMonitor(ScaledActions(MultiRobotVecEnv(2, 3, **ARGUMENTS)))
    model = PPO("MlpPolicy", env, n_steps=32, batch_size=96, n_epochs=1, seed=1)
    model.learn(200)
    assert model.num_timesteps >= 200
    assert policy_of(model).act(np.zeros((5, 21), np.float32)).shape == (5, 2)


@pytest.mark.parametrize("kind", [NavigationVecEnv, MultiRobotVecEnv])
def test_copies_are_made_by_the_same_arguments(kind):
    env = kind(2, **ARGUMENTS)
    copied = pickle.loads(pickle.dumps(env))
    assert_same(drive(copied, 20), drive(env, 20))


def test_ppo_learns_with_it():
    env = VecMonitor(NavigationVecEnv(8, **ARGUMENTS))
    model = PPO("MlpPolicy", env, n_steps=64, batch_size=256, n_epochs=2, seed=1)
    model.learn(1500)
    assert model.num_timesteps >= 1500


@pytest.mark.parametrize("wrap", [ScaledActions, lambda env: env], ids=["scaled", "in units"])
def test_a_model_becomes_a_policy(wrap):
    env = NavigationVecEnv(4, **ARGUMENTS)
    model = PPO("MlpPolicy", wrap(env), n_steps=16, batch_size=64, seed=1)
    model.policy.action_net.weight.data *= 40.0  # actions are not all about zero
    observations = env.envs.observation_space.sample()
    expected, _ = model.predict(observations, deterministic=True)
    if wrap is ScaledActions:
        expected = expected * env.action_space.high

    found = policy_of(model).act(observations)
    assert found == pytest.approx(expected, abs=1e-5)
    assert np.unique(found).size > 4


def test_other_models_are_refused():
    env = NavigationVecEnv(2, **ARGUMENTS)
    relu = {"activation_fn": torch.nn.ReLU}
    with pytest.raises(UsageError, match="expected tanh between the layers"):
        policy_of(PPO("MlpPolicy", env, n_steps=16, batch_size=32, policy_kwargs=relu))
    with pytest.raises(UsageError, match="expected an MlpPolicy of PPO or A2C"):
        policy_of(SAC("MlpPolicy", env, buffer_size=10))
    with pytest.raises(UsageError, match="expected a model with a NavigationVecEnv"):
        policy_of(PPO("MlpPolicy", DummyVecEnv([lambda: make(**ARGUMENTS)]), n_steps=16))


@pytest.mark.parametrize(
    "wrap", [VecNormalize, lambda env: VecFrameStack(env, 2)], ids=["normalised", "stacked"]
)
def test_a_wrapper_that_changes_what_the_policy_sees_is_refused(wrap):
    env = wrap(ScaledActions(NavigationVecEnv(2, **ARGUMENTS)))
    name = type(env).__name__
    model = PPO("MlpPolicy", VecMonitor(env), n_steps=16, batch_size=32)
    with pytest.raises(UsageError, match=f"expected no {name}: a robot that is driven by the pol"):
        policy_of(model)
    with pytest.raises(UsageError, match=f"expected no {name}"):
        mirrored(env)


def test_ppo_learns_from_mirror_images():
    env = ScaledActions(NavigationVecEnv(8, **ARGUMENTS))
    arguments = {"n_steps": 16, "batch_size": 128, "n_epochs": 1, "seed": 1}
    model = PPO("MlpPolicy", env, **arguments, **mirrored(env))
    model.learn(128)
    buffer, mirror = model.rollout_buffer, Mirror.of(env.venv.envs.navigation)
    chosen = np.arange(100)
    rows = buffer._get_samples(chosen)
    observations, actions = buffer.observations[chosen], buffer.actions[chosen]
    mirror.turn(observations[:50], actions[:50])
    np.testing.assert_allclose(rows.observations.numpy(), observations)
    np.testing.assert_allclose(rows.actions.numpy(), actions)
    assert np.abs(rows.actions.numpy() - buffer.actions[chosen]).max() > 0.1


def test_a_lidar_off_the_axis_cannot_be_mirrored():
    content = world_content("package://flatland_gym/worlds/empty_room.yaml")
    content["models"][0]["model"]["plugins"][1]["origin"] = [0, 0.1, 0]
    env = NavigationVecEnv(2, world=content)
    with pytest.raises(UsageError, match="a lidar that looks to both sides alike"):
        mirrored(env)


def test_wrong_calls_are_refused():
    with pytest.raises(UsageError, match="expected no autoreset_mode"):
        NavigationVecEnv(2, autoreset_mode="NextStep")
    env = NavigationVecEnv(2, **ARGUMENTS)
    env.set_options([{"goal": [1, 1]}, {}])
    with pytest.raises(UsageError, match="the same options"):
        env.reset()
