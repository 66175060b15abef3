"""The environments of Stable-Baselines3: what its DummyVecEnv gives for single ones."""

import numpy as np
import pytest
from environments import assert_same, make

from flatland_server import UsageError

pytest.importorskip("stable_baselines3")

from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import DummyVecEnv, VecMonitor

from flatland_gym.sb3 import NavigationVecEnv

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
def test_it_equals_so_many_single_environments(flatten):
    arguments = {**ARGUMENTS, "flatten": flatten}
    expected = drive(DummyVecEnv([lambda: make(**arguments)] * 5), 120)
    found = drive(NavigationVecEnv(5, **arguments), 120)

    assert_same([dict(each) if isinstance(each, dict) else each for each in expected], found)
    infos = [info for result in found[1:] for info in result[3]]
    assert any("terminal_observation" in info for info in infos)
    assert any(info["TimeLimit.truncated"] for info in infos)


def test_ppo_learns_with_it():
    env = VecMonitor(NavigationVecEnv(8, **ARGUMENTS))
    model = PPO("MlpPolicy", env, n_steps=64, batch_size=256, n_epochs=2, seed=1)
    model.learn(1500)
    assert model.num_timesteps >= 1500
    env.close()


def test_wrong_calls_are_refused():
    with pytest.raises(UsageError, match="expected no autoreset_mode"):
        NavigationVecEnv(2, autoreset_mode="NextStep")
    env = NavigationVecEnv(2, **ARGUMENTS)
    env.set_options([{"goal": [1, 1]}, {}])
    with pytest.raises(UsageError, match="the same options"):
        env.reset()
    env.close()
