"""Training by the PPO of Stable-Baselines3, and policies out of its models."""

import time
from typing import Any, Callable, Dict, List, Tuple

import numpy as np
from gymnasium import spaces

from flatland2d import UsageError
from flatland_gym.policy import Policy
from flatland_gym.sb3 import NavigationVecEnv
from flatland_gym.training_progress import Progress, TrainingBar, TrainingInterrupted
from flatland_server import Float32Array

# After flatland_gym.sb3, which reports missing packages.
import torch  # isort: skip
from stable_baselines3 import PPO  # isort: skip
from stable_baselines3.common.callbacks import BaseCallback  # isort: skip
from stable_baselines3.common.vec_env import VecEnvWrapper, VecMonitor  # isort: skip

PPO_ARGUMENTS: Dict[str, Any] = {
    "n_steps": 64,
    "batch_size": 1024,
    "n_epochs": 6,
    "learning_rate": 1e-3,
    "ent_coef": 1e-3,
    "policy_kwargs": {"log_std_init": -0.5},
}
"""Arguments of PPO for 64 to 128 environments: the settings of `flatland_gym.ppo`."""


class ScaledActions(VecEnvWrapper):
    """Actions of [-1, 1], in units of the drive's limits, as PPO's exploration expects.

    Args:
        venv: the environments.
    """

    def __init__(self, venv: NavigationVecEnv) -> None:
        self._limits = venv.action_space.high
        super().__init__(venv, action_space=spaces.Box(-1.0, 1.0, self._limits.shape, np.float32))

    def reset(self) -> Any:
        return self.venv.reset()

    def step_async(self, actions: Any) -> None:
        self.venv.step_async(np.clip(actions, -1.0, 1.0) * self._limits)

    def step_wait(self) -> Any:
        return self.venv.step_wait()


class _Report(BaseCallback):
    """Reports after each rollout, and ends the training at its limits."""

    def __init__(self, seconds: float, report: Callable[[Progress], None]) -> None:
        super().__init__()
        self._seconds = seconds
        self._report = report
        self._began = time.monotonic()
        self._ended: List[Tuple[bool, float]] = []

    def _on_training_start(self) -> None:
        self._began = time.monotonic()

    def _on_step(self) -> bool:
        for info in self.locals["infos"]:
            if "episode" in info:
                self._ended.append((info["success"], info["episode"]["r"]))
        return time.monotonic() - self._began < self._seconds

    def _on_rollout_end(self) -> None:
        success, reward = np.mean(self._ended, axis=0) if self._ended else (np.nan, np.nan)
        elapsed = time.monotonic() - self._began
        count, self._ended = len(self._ended), []
        self._report(Progress(self.num_timesteps, elapsed, count, float(success), float(reward)))


def train(
    env: NavigationVecEnv,
    seed: int,
    steps: int,
    seconds: float,
    report: Callable[[Progress], None],
    progress_bar: bool = False,
) -> Policy:
    """Trains by PPO with `PPO_ARGUMENTS`, and closes the environments.

    Args:
        env: the environments.
        seed: of all random numbers.
        steps: to train at most, of all environments together.
        seconds: to train at most.
        report: called after each rollout.
        progress_bar: whether tqdm shows a bar, as in `Ppo.train`.

    Raises:
        TrainingInterrupted: Ctrl-C.
    """
    bar = TrainingBar(steps, seconds) if progress_bar else None

    def show(now: Progress) -> None:
        report(now)
        if bar is not None:
            bar.show(now)

    torch.set_num_threads(1)  # quicker than two for networks of 64 x 64
    model = PPO("MlpPolicy", VecMonitor(ScaledActions(env)), seed=seed, **PPO_ARGUMENTS)
    try:
        model.learn(steps, callback=_Report(seconds, show))
    except KeyboardInterrupt:
        raise TrainingInterrupted(policy_of(model)) from None
    finally:
        env.close()
        if bar is not None:
            bar.close()
    return policy_of(model)


def policy_of(model: Any) -> Policy:
    """The policy of a model that was trained with a `NavigationVecEnv`, for files and for robots.

    Args:
        model: with an "MlpPolicy" of layers with tanh between them, as PPO and A2C have it.

    Raises:
        UsageError: its policy is another one, or its environments are.
    """
    env, is_scaled = model.get_env(), False
    while env is not None and not isinstance(env, NavigationVecEnv):
        is_scaled = is_scaled or isinstance(env, ScaledActions)
        env = getattr(env, "venv", None)
    if env is None or not env.envs.navigation.settings.flatten:
        raise UsageError("expected a model with a NavigationVecEnv of flat observations")
    network = getattr(getattr(model.policy, "mlp_extractor", None), "policy_net", None)
    last = getattr(model.policy, "action_net", None)
    if network is None or last is None:
        raise UsageError(f"expected an MlpPolicy of PPO or A2C, found {type(model.policy)}")
    hidden, others = list(network)[::2], list(network)[1::2]
    if not all(isinstance(each, torch.nn.Tanh) for each in others):
        raise UsageError(f"expected tanh between the layers, found {others}")
    layers = [(_array(each.weight).T.copy(), _array(each.bias)) for each in (*hidden, last)]
    if not is_scaled:
        limits = np.array(env.envs.navigation.robot.action_limits, np.float32)
        layers[-1] = (layers[-1][0] / limits, layers[-1][1] / limits)
    weights, biases = zip(*layers)
    return env.envs.navigation.policy(weights, biases)


def _array(tensor: Any) -> Float32Array:
    values: Float32Array = tensor.detach().numpy().copy()
    return values
