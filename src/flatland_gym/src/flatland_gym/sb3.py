"""Environments for Stable-Baselines3, which does not take Gymnasium's vector environments."""

from typing import Any, Dict, Iterable, List, Optional, Sequence, Type, Union

import numpy as np

from flatland2d import MissingPackageError, UsageError
from flatland_gym.multi_robot_vector_env import MultiRobotVectorEnv
from flatland_gym.navigation import row_of
from flatland_gym.navigation_vector_env import NavigationVectorEnv
from flatland_gym.pickling import ByArguments
from flatland_server.exceptions import pip_install

try:
    from stable_baselines3.common.vec_env import VecEnv
except ImportError:
    raise MissingPackageError(
        f"flatland_gym.sb3 needs Stable-Baselines3: {pip_install('sb3')}"
    ) from None

Indices = Union[None, int, Iterable[int]]


class NavigationVecEnv(ByArguments, VecEnv):
    """`NavigationVectorEnv` for the learners of Stable-Baselines3.

        model = PPO("MlpPolicy", NavigationVecEnv(num_envs=64, world="discs"))

    An environment begins the next episode at once. Its info then has the `terminal_observation`,
    and `TimeLimit.truncated` if the episode was only cut off; the other keys are those of the step
    that has ended it, and `reset_infos` has those of the reset.

    Args:
        num_envs: number of environments, n.
        arguments: those of `NavigationVectorEnv`, but its `autoreset_mode`.

    Raises:
        FlatlandError: an argument is wrong, or the world cannot be used.
    """

    _KIND: Type[NavigationVectorEnv] = NavigationVectorEnv
    _AXES = 1
    """Axes of its arrays before those of a row."""

    def __init__(self, num_envs: int = 1, **arguments: Any) -> None:
        if "autoreset_mode" in arguments:
            raise UsageError("expected no autoreset_mode: Stable-Baselines3 has one of its own")
        env = self._KIND(num_envs, autoreset_mode="SameStep", **arguments)
        self.envs = env
        self.metadata = env.metadata
        self.render_mode = env.render_mode
        self._actions: Any = None
        robots = env.navigation
        super().__init__(len(robots.goals), robots.observation_space, robots.action_space)
        self._robots = self.num_envs // env.num_envs  # in each environment

    def reset(self) -> Any:
        """Begins an episode in all environments; returns the observations."""
        seeds, options = list(self._seeds[: self.envs.num_envs]), self._common_options()
        has_seeds = any(seed is not None for seed in seeds)
        observations, infos = self.envs.reset(seed=seeds if has_seeds else None, options=options)
        self._reset_seeds()
        self._reset_options()
        self.reset_infos = self._split(infos)
        return _flat(observations, self._AXES)

    def step_async(self, actions: Any) -> None:
        """Takes the actions of the next step."""
        self._actions = actions

    def step_wait(self) -> Any:
        """Makes a step: observations, rewards (float32), ends and infos."""
        observations, rewards, _, truncated, found = self.envs.step(self._actions)
        ended, infos, robots = np.zeros(self.num_envs, bool), self._split(found), self._robots
        if "_final_obs" in found:
            ended = np.repeat(found["_final_obs"], robots)
            final = self._parts(found["final_info"])
            for index in np.flatnonzero(ended).tolist():
                self.reset_infos[index] = infos[index]
                last = _flat(found["final_obs"][index // robots], self._AXES - 1)
                infos[index] = row_of(final, index)
                infos[index]["terminal_observation"] = _row(last, index % robots)
        for info, is_truncated in zip(infos, truncated.ravel().tolist()):
            info["TimeLimit.truncated"] = is_truncated
        rewards = rewards.ravel().astype(np.float32)
        return _flat(observations, self._AXES), rewards, ended, infos

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
        """An info for each row."""
        parts = self._parts(infos)
        return [row_of(parts, index) for index in range(self.num_envs)]

    def _parts(self, infos: Dict[str, Any]) -> Dict[str, Any]:
        """The infos of the last step alone, with a row for each robot."""
        names = [name for name in infos if not name.startswith(("_", "final_"))]
        return {name: _flat(infos[name], self._AXES) for name in names}


class MultiRobotVecEnv(NavigationVecEnv):
    """`MultiRobotVectorEnv` for Stable-Baselines3: one policy that drives all robots.

        model = PPO("MlpPolicy", MultiRobotVecEnv(num_envs=16, robots=4, world="discs"))

    Each robot is an environment of the learner, and `num_envs` is their number: those of the first
    environment come first. After the end of its episode, a robot gets zeros, and rewards of 0,
    until the episodes of all robots of its environment have ended; then all are done, and begin
    the next.

    Args:
        num_envs: number of environments, n.
        robots: number of robots in each, two at least.
        arguments: those of `MultiRobotVectorEnv`, but its `autoreset_mode`.

    Raises:
        FlatlandError: an argument is wrong, or the world cannot be used.
    """

    _KIND, _AXES = MultiRobotVectorEnv, 2

    def __init__(self, num_envs: int = 1, robots: int = 2, **arguments: Any) -> None:
        super().__init__(num_envs, robots=robots, **arguments)

    def step_async(self, actions: Any) -> None:
        """Takes the actions of the next step, a row for each robot."""
        rows = np.asarray(actions)
        shape = (self.envs.num_envs, self._robots, *self.action_space.shape)
        self._actions = rows.reshape(shape) if rows.size == np.prod(shape) else rows


def _flat(values: Any, axes: int) -> Any:
    """Arrays with one axis of rows in place of so many first ones; also as a dict."""
    if isinstance(values, dict):
        return {name: _flat(each, axes) for name, each in values.items()}
    return values.reshape(-1, *values.shape[axes:])


def _row(values: Any, index: int) -> Any:
    """The row of an array, or of each of a dict."""
    if isinstance(values, dict):
        return {name: each[index] for name, each in values.items()}
    return values[index]
