"""Environments for Stable-Baselines3, which does not take Gymnasium's vector environments."""

from typing import Any, Dict, Iterable, List, Optional, Sequence, Union

import numpy as np

from flatland2d import MissingPackageError, UsageError
from flatland_gym.navigation import row_of
from flatland_gym.navigation_vector_env import NavigationVectorEnv

try:
    from stable_baselines3.common.vec_env import VecEnv
except ImportError:
    raise MissingPackageError(
        "flatland_gym.sb3 needs Stable-Baselines3: pip install 'flatland2d[sb3]'"
    ) from None

Indices = Union[None, int, Iterable[int]]


class NavigationVecEnv(VecEnv):
    """`NavigationVectorEnv` for the learners of Stable-Baselines3.

        model = PPO("MlpPolicy", NavigationVecEnv(num_envs=64, world="discs"))

    An environment begins the next episode at once. Its info then has the `terminal_observation`,
    and `TimeLimit.truncated` if the episode was only cut off; the other keys are those of the step
    that has ended it, and `reset_infos` has those of the reset.

    Args:
        num_envs: how many environments there are.
        arguments: those of `NavigationVectorEnv`, but its `autoreset_mode`.

    Raises:
        FlatlandError: an argument is wrong, or the world cannot be used.
    """

    def __init__(self, num_envs: int = 1, **arguments: Any) -> None:
        if "autoreset_mode" in arguments:
            raise UsageError("expected no autoreset_mode: Stable-Baselines3 has one of its own")
        env = NavigationVectorEnv(num_envs, autoreset_mode="SameStep", **arguments)
        self.envs = env
        self.metadata = env.metadata
        self.render_mode = env.render_mode
        self._actions: Any = None
        super().__init__(env.num_envs, env.single_observation_space, env.single_action_space)

    def reset(self) -> Any:
        """Begins an episode in all environments; returns the observations."""
        seeds, options = list(self._seeds), self._common_options()
        has_seeds = any(seed is not None for seed in seeds)
        observations, infos = self.envs.reset(seed=seeds if has_seeds else None, options=options)
        self._reset_seeds()
        self._reset_options()
        self.reset_infos = self._split(infos)
        return observations

    def step_async(self, actions: Any) -> None:
        """Takes the actions of the next step."""
        self._actions = actions

    def step_wait(self) -> Any:
        """Makes a step: observations, rewards (float32), ends and infos."""
        observations, rewards, terminated, truncated, found = self.envs.step(self._actions)
        ended = terminated | truncated
        infos = self._split(found)
        for index in np.flatnonzero(ended).tolist():
            self.reset_infos[index] = infos[index]
            infos[index] = _row(found["final_info"], index)
            infos[index]["terminal_observation"] = found["final_obs"][index]
        for info, is_truncated in zip(infos, truncated.tolist()):
            info["TimeLimit.truncated"] = is_truncated
        return observations, rewards.astype(np.float32), ended, infos

    def close(self) -> None:
        """Ends all simulations."""
        self.envs.close()

    def get_images(self) -> Sequence[Optional[Any]]:
        """The pictures of all environments."""
        frames = self.envs.render() if self.render_mode == "rgb_array" else None
        return list(frames) if frames is not None else [None] * self.num_envs

    def get_attr(self, attr_name: str, indices: Indices = None) -> List[Any]:
        """An attribute of the vector environment, for each of these environments."""
        value = getattr(self.envs, attr_name)
        return [value for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Indices = None) -> None:
        """Sets an attribute of the vector environment: all environments share it."""
        if indices is not None:
            raise UsageError("expected no indices: the environments share their attributes")
        setattr(self.envs, attr_name, value)

    def env_method(self, method_name: str, *args: Any, indices: Indices = None, **kw: Any) -> Any:
        """Calls a method of the vector environment, once; its result for each environment."""
        result = getattr(self.envs, method_name)(*args, **kw)
        return [result for _ in self._get_indices(indices)]

    def env_is_wrapped(self, wrapper_class: Any, indices: Indices = None) -> List[bool]:
        """False for each environment: none is wrapped."""
        return [False for _ in self._get_indices(indices)]

    def _common_options(self) -> Dict[str, Any]:
        """The options of `set_options`, which are the same for all environments."""
        options = list(self._options)
        if any(each != options[0] for each in options):
            raise UsageError("expected the same options for all environments")
        return dict(options[0])

    def _split(self, infos: Dict[str, Any]) -> List[Dict[str, Any]]:
        """An info for each environment."""
        return [_row(infos, index) for index in range(self.num_envs)]


def _row(infos: Dict[str, Any], index: int) -> Dict[str, Any]:
    """The info of one environment, of the last step alone."""
    parts = {name: infos[name] for name in infos if not name.startswith(("_", "final_"))}
    return row_of(parts, index)
