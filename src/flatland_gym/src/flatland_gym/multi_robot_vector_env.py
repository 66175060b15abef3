"""`MultiRobotEnv` many times, in one call of the core: arrays of environments and robots."""

from typing import Any, Dict, Mapping, Tuple

import numpy as np
from gymnasium import spaces
from gymnasium.vector.utils import batch_space

from flatland_gym.navigation import Navigation, Steps
from flatland_gym.navigation_vector_env import NavigationVectorEnv
from flatland_gym.settings import NavigationSettings
from flatland_gym.team import Team, check_team
from flatland_server import BoolArray, Float32Array, FloatArray


class MultiRobotVectorEnv(NavigationVectorEnv):
    """n environments with m robots each; see `MultiRobotEnv` for what each one is.

    Observations, actions, rewards, ends and infos have the shape (n, m, ...), with zeros for robots
    after the end of their episodes. An environment is reset, as the autoreset mode says, when the
    episodes of all its robots have ended. The results equal, bit for bit, those of n
    `MultiRobotEnv`. Actions of robots after the end of their episodes have no effect.

    Args:
        num_envs: number of environments, n.
        robots: number of robots in each, m: two at least.
        at_goal: as for `MultiRobotEnv`.
        shared_rewards: as for `MultiRobotEnv`.
        arguments: those of `NavigationVectorEnv`.

    Attributes:
        possible_agents: the names of the robots, in the order of the arrays.

    Raises:
        FlatlandError: an argument is wrong, or the world cannot be used.
    """

    _STATE = (*NavigationVectorEnv._STATE, "present", "acted")

    def __init__(
        self,
        num_envs: int = 1,
        robots: int = 2,
        at_goal: str = "leave",
        shared_rewards: float = 0.0,
        **arguments: Any,
    ) -> None:
        self._rules = robots, at_goal, shared_rewards
        super().__init__(num_envs, **arguments)
        self._team = Team(self.navigation, at_goal, shared_rewards, self._most_steps)
        self._acted = np.zeros_like(self._team.present)  # in the last step, or reset
        self.possible_agents = list(self.navigation.robot_names)

    def state(self) -> Float32Array:
        """The states of the environments: a new array; a row is `MultiRobotEnv.state`."""
        return self._team.state()

    def _drive(self, actions: FloatArray, restarted: BoolArray) -> Steps:
        self._acted = self._team.present.copy()
        return self._team.step(actions.reshape(-1, actions.shape[-1]))

    def _are_over(self, ended: BoolArray) -> BoolArray:
        over: BoolArray = ~self._team.present.any(axis=1)
        return over

    def _make_navigation(self, settings: NavigationSettings, threads: int) -> Navigation:
        check_team(*self._rules, settings)
        return Navigation(settings, self.num_envs, threads, robots=int(self._rules[0]))

    def _spaces(self) -> Tuple[spaces.Box, Any]:
        robots = len(self.navigation.robot_names)
        action, observation = (batch_space(space, robots) for space in super()._spaces())
        assert isinstance(action, spaces.Box)
        return action, observation

    def _begin(self, indices: Any, options: Mapping[str, Any]) -> None:
        super()._begin(indices, options)
        self._team.present[indices] = self._acted[indices] = True

    def _own_state(self, index: int) -> Dict[str, Any]:
        robots = {"present": self._team.present, "acted": self._acted}
        marks = {name: each[index].tolist() for name, each in robots.items()}
        return {**super()._own_state(index), **marks}

    def _take_state(self, index: int, state: Mapping[str, Any]) -> None:
        super()._take_state(index, state)
        self._team.present[index], self._acted[index] = state["present"], state["acted"]

    def _flat(self) -> Float32Array:
        flat = self.navigation.observe()
        flat[~self._acted.ravel()] = 0.0
        return flat.reshape(*self._acted.shape, -1)

    def _infos(self, chosen: BoolArray) -> Dict[str, Any]:
        """Infos with the values of some environments, and `present`: the robots that go on."""
        shape, absent = self._acted.shape, ~(self._acted & chosen[:, None])
        infos: Dict[str, Any] = {"present": self._team.present & chosen[:, None]}
        for name, values in self.navigation.info().items():
            infos[name] = values.reshape(*shape, *values.shape[1:])
            infos[name][absent] = 0
        return infos

    def _row(self, index: int) -> int:
        """The row of the first robot that is there."""
        return index * self._acted.shape[1] + int(self._team.present[index].argmax())
