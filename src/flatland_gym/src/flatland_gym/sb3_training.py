"""PPO of Stable-Baselines3 for our environments, and policies out of its models."""

from typing import Any, Dict

import numpy as np
from gymnasium import spaces

from flatland2d import UsageError
from flatland_gym.navigation import Navigation
from flatland_gym.policy import Policy
from flatland_gym.sb3 import NavigationVecEnv
from flatland_gym.train import Mirror
from flatland_server import Float32Array

# After flatland_gym.sb3, which reports missing packages.
import torch  # isort: skip
from stable_baselines3.common.buffers import RolloutBuffer  # isort: skip
from stable_baselines3.common.vec_env import (  # isort: skip
    VecCheckNan,
    VecEnvWrapper,
    VecMonitor,
    VecVideoRecorder,
    unwrap_vec_wrapper,
)

PPO_ARGUMENTS: Dict[str, Any] = {
    "n_steps": 64,
    "batch_size": 1024,
    "n_epochs": 6,
    "learning_rate": 1e-3,
    "ent_coef": 1e-3,
    "policy_kwargs": {"log_std_init": -0.5},
}
"""Arguments of PPO for 64 to 128 environments: the settings of `flatland_gym.train`."""


class ScaledActions(VecEnvWrapper):
    """Actions of [-1, 1], in units of the drive's limits, as PPO's exploration expects.

    Args:
        venv: environments with actions in the drive's units.
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


_TRANSPARENT = (ScaledActions, VecMonitor, VecCheckNan, VecVideoRecorder)
"""Wrappers that leave observations as they are, and actions or their scale."""


class MirroredRollouts(RolloutBuffer):
    """A rollout buffer of PPO that exchanges left and right in half of each minibatch.

    Args:
        arguments: the buffer's arguments.
        mirror: of the environments; see `mirrored`.
        named: further arguments of the buffer.
    """

    def __init__(self, *arguments: Any, mirror: Mirror, **named: Any) -> None:
        super().__init__(*arguments, **named)
        self._mirror = mirror

    def _get_samples(self, batch_inds: Any, env: Any = None) -> Any:
        rows = super()._get_samples(batch_inds, env)
        half, signs = len(batch_inds) // 2, self.to_torch(self._mirror.signs)
        rows.observations[:half] = rows.observations[:half][:, self._mirror.order] * signs
        rows.actions[:half] *= self.to_torch(self._mirror.action_signs)
        return rows


def mirrored(env: Any) -> Dict[str, Any]:
    """Arguments of PPO that make it learn from mirror images, too: half of its rows.

        PPO("MlpPolicy", env, **mirrored(env), **PPO_ARGUMENTS)

    Args:
        env: a `NavigationVecEnv`, also in `ScaledActions`.

    Raises:
        UsageError: its robot's lidar does not look to both sides alike, its observations are no
            flat arrays, or a wrapper may change them.
    """
    mirror = Mirror.of(_navigation(env))
    if mirror is None:
        raise UsageError("expected a robot with a lidar that looks to both sides alike")
    return {"rollout_buffer_class": MirroredRollouts, "rollout_buffer_kwargs": {"mirror": mirror}}


def _navigation(env: Any) -> Navigation:
    """The navigation of environments, of which no wrapper changes the observations.

    Raises:
        UsageError: they are others, or a wrapper may change them.
    """
    while isinstance(env, VecEnvWrapper):
        if not isinstance(env, _TRANSPARENT):
            raise UsageError(
                f"expected no {type(env).__name__}: a robot that is driven by the policy does not "
                "have what this wrapper may change in observations or actions"
            )
        env = env.venv
    if not isinstance(env, NavigationVecEnv) or not env.envs.navigation.settings.flatten:
        raise UsageError("expected a model with a NavigationVecEnv of flat observations")
    return env.envs.navigation


def policy_of(model: Any) -> Policy:
    """The policy of a model that was trained with a `NavigationVecEnv`, for files and for robots.

    Args:
        model: with an "MlpPolicy" of layers with tanh between them, as PPO and A2C have it.

    Raises:
        UsageError: its policy is another one, its environments are, or a wrapper changes what the
            policy sees, such as VecNormalize and VecFrameStack.
    """
    env = model.get_env()
    navigation = _navigation(env)
    network = getattr(getattr(model.policy, "mlp_extractor", None), "policy_net", None)
    last = getattr(model.policy, "action_net", None)
    if network is None or last is None:
        raise UsageError(f"expected an MlpPolicy of PPO or A2C, found {type(model.policy)}")
    hidden, others = list(network)[::2], list(network)[1::2]
    if not all(isinstance(each, torch.nn.Tanh) for each in others):
        raise UsageError(f"expected tanh between the layers, found {others}")
    layers = [(_array(each.weight).T.copy(), _array(each.bias)) for each in (*hidden, last)]
    if unwrap_vec_wrapper(env, ScaledActions) is None:
        limits = np.array(navigation.robot.action_limits, np.float32)
        layers[-1] = (layers[-1][0] / limits, layers[-1][1] / limits)
    weights, biases = zip(*layers)
    return navigation.policy(weights, biases)


def _array(tensor: Any) -> Float32Array:
    values: Float32Array = tensor.detach().numpy().copy()
    return values
