"""`flatland/Navigation-v0` for many robots at a time, each in a world of its own: a VectorEnv.

It gives, bit for bit, what `gymnasium.vector.SyncVectorEnv` gives for so many single environments:
observations, rewards, ends and infos, in each autoreset mode.
"""

import sys
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np
from gymnasium import spaces
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from flatland2d import UsageError
from flatland2d.batch.arguments import states_of
from flatland2d.rendering.film import side_by_side
from flatland_gym.episodes import options_of
from flatland_gym.navigation import Navigation, Steps
from flatland_gym.pickling import ByArguments
from flatland_gym.pictures import check_render_mode
from flatland_gym.settings import NavigationSettings, is_whole
from flatland_server import BoolArray, Float32Array, FloatArray, plain_data

_IN_NOTEBOOKS = 9

Seeds = Union[None, int, Sequence[Optional[int]]]


class NavigationVectorEnv(ByArguments, VectorEnv[Any, Any, Any]):
    """n environments; see `NavigationEnv` for what each one is.

    Arrays that are returned are new ones in each call, and never written to again.

    Args:
        num_envs: number of environments, n.
        threads: how many are stepped at a time; results do not depend on it.
        autoreset_mode: what follows the end of an episode: "NextStep", "SameStep" or "Disabled".
        render_mode: None, "rgb_array" or "ansi".
        render_envs: how many environments `render` shows, from the first one on; None: all.
        max_episode_steps: after which an episode is truncated, as by Gymnasium's TimeLimit; None:
            only `time_limit` counts.
        arguments: the attributes of `NavigationSettings`.

    Raises:
        FlatlandError: an argument is wrong, or the world cannot be used.
    """

    _STATE: Tuple[str, ...] = (
        *(
            "world",
            "simulation",
            "goal",
            "distance",
            "success",
            "collided",
            "steps",
            "episode",
            "map",
            "vary",
        ),
        *("rng", "seed", "ended"),
    )
    """The keys of a state."""

    def __init__(
        self,
        num_envs: int = 1,
        threads: int = 1,
        autoreset_mode: Union[str, AutoresetMode] = AutoresetMode.NEXT_STEP,
        render_mode: Optional[str] = None,
        render_envs: Optional[int] = None,
        max_episode_steps: Optional[int] = None,
        **arguments: Any,
    ) -> None:
        shown = num_envs if render_envs is None else render_envs
        counts = {"num_envs": num_envs, "threads": threads, "render_envs": shown}
        if max_episode_steps is not None:
            counts["max_episode_steps"] = max_episode_steps
        for name, value in counts.items():
            if not (is_whole(value) and value >= 1):
                raise UsageError(f"expected {name} to be a whole number above 0, found {value!r}")
        check_render_mode(render_mode)
        if render_mode == "human":
            raise UsageError('render_mode="human" is for a single environment: use gym.make')
        settings = NavigationSettings.of(arguments)
        self.num_envs = int(num_envs)
        self.autoreset_mode = _mode(autoreset_mode)
        self.render_mode = render_mode
        self._most_steps = sys.maxsize if max_episode_steps is None else int(max_episode_steps)
        self._shown = min(int(shown), self.num_envs)
        self.navigation = self._make_navigation(settings, int(threads))
        self.metadata = {**self.navigation.metadata, "autoreset_mode": self.autoreset_mode}
        self.single_action_space: spaces.Box
        self.single_action_space, self.single_observation_space = self._spaces()
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self._generators: List[Optional[np.random.Generator]] = [None] * self.num_envs
        self._seeds: List[int] = [-1] * self.num_envs
        self._ended = np.zeros(self.num_envs, dtype=bool)
        self._is_running = False

    @property
    def reset_options(self) -> Dict[str, Any]:
        """Options of all resets from now on, also of automatic ones: a curriculum's.

        Those that are given to `reset` come first. Setting a wrong one raises a UsageError, and
        changes nothing.
        """
        return self.navigation.options

    @reset_options.setter
    def reset_options(self, options: Optional[Mapping[str, Any]]) -> None:
        self.navigation.options = options

    def reset(
        self, *, seed: Seeds = None, options: Optional[Mapping[str, Any]] = None
    ) -> Tuple[Any, Dict[str, Any]]:
        """Begins an episode in all environments, or in those of `options["reset_mask"]`.

        Args:
            seed: None goes on with the random numbers there are; with a number, environment k gets
                the seed of that number + k; a list has a seed or None for each.
            options: as for `NavigationEnv.reset`, for all that are reset; and `reset_mask`, an
                array of n booleans.

        Raises:
            UsageError: an option or a seed is wrong. The environments are as before.
        """
        options = options_of(options)
        chosen = self._chosen(options.pop("reset_mask", None))
        indices = np.flatnonzero(chosen)
        former = list(self._generators), list(self._seeds)
        try:
            self._seed(_seeds(seed, self.num_envs), indices.tolist())
            self._begin(indices, options)
        except BaseException:
            self._generators, self._seeds = former
            raise
        self._ended[indices] = False
        self._is_running = True
        return self._observations(), self._infos(chosen)

    def step(self, actions: Any) -> Tuple[Any, FloatArray, BoolArray, BoolArray, Dict[str, Any]]:
        """Drives all robots for `frame_skip` steps.

        With "NextStep", an environment is reset instead after its episode has ended, with a reward
        of 0. With "SameStep" it is reset at once, and the infos have the last observation of the
        episode (`final_obs`) and its info (`final_info`).

        Args:
            actions: shape (n, size of an action); what is beyond the limits is cut to them.

        Raises:
            UsageError: the actions have another shape, are no numbers or not finite; there was no
                reset, or, with "Disabled", none after the end of an episode. All is as before.
        """
        checked, mode = self._checked(actions), self.autoreset_mode
        restarted = self._ended if mode == AutoresetMode.NEXT_STEP else np.zeros_like(self._ended)
        rewards, terminated, truncated = self._drive(checked, restarted)
        if restarted.any():
            self._begin(np.flatnonzero(restarted), {})
        self._ended = self._are_over(terminated | truncated)
        final: Dict[str, Any] = {}
        if mode == AutoresetMode.SAME_STEP and self._ended.any():
            final = self._final(self._ended)
            self._begin(np.flatnonzero(self._ended), {})
        infos = self._infos(np.ones_like(self._ended))
        return self._observations(), rewards, terminated, truncated, {**final, **infos}

    def save_states(self, mask: Optional[BoolArray] = None) -> List[bytes]:
        """The states of environments: their simulations, episodes and random numbers.

        Args:
            mask: an array of n booleans: which environments; None: all.

        Returns:
            A state for each of them, in their order: for `load_states` here, in another process, or
            with another number of environments.

        Raises:
            FlatlandError: there was no reset, the mask is wrong, or a state cannot be saved.
        """
        if not self._is_running:
            raise UsageError("expected reset before save_states")
        indices = np.flatnonzero(self._chosen(mask, "mask"))
        return [
            plain_data.dumps({**state, **self._own_state(k)})
            for k, state in zip(indices.tolist(), self.navigation.save_states(indices))
        ]

    def load_states(
        self, states: Union[bytes, Sequence[bytes]], mask: Optional[BoolArray] = None
    ) -> Tuple[Any, Dict[str, Any]]:
        """Puts environments into saved states: their episodes go on from there, bit for bit.

        Args:
            states: of `save_states`: one for all these environments, or one for each, in their
                order.
            mask: an array of n booleans: which environments; None: all.

        Returns:
            Observations and infos, as `reset` does.

        Raises:
            FlatlandError: the mask is wrong, or a state is damaged or does not fit.
        """
        chosen = self._chosen(mask, "mask")
        indices = np.flatnonzero(chosen)
        given = states_of(states, len(indices))
        loaded = {state: self._content_of(state) for state in dict.fromkeys(given)}
        self.navigation.load_states(indices, [loaded[state] for state in given])
        for k, state in zip(indices.tolist(), (loaded[each] for each in given)):
            self._take_state(k, state)
        self._is_running = True
        return self._observations(), self._infos(chosen)

    def _own_state(self, index: int) -> Dict[str, Any]:
        """The part of an environment's state that `navigation` does not have."""
        return {
            "rng": self._generator(index).bit_generator.state,
            "seed": self._seeds[index],
            "ended": bool(self._ended[index]),
        }

    def _take_state(self, index: int, state: Mapping[str, Any]) -> None:
        """Puts back what `_own_state` has given."""
        self._generator(index).bit_generator.state = state["rng"]
        self._seeds[index], self._ended[index] = state["seed"], state["ended"]

    def _content_of(self, state: bytes) -> Dict[str, Any]:
        """The content of a state.

        Raises:
            UsageError: it is none, damaged, or of another kind of environment.
        """
        try:
            content = plain_data.loads(state)
        except ValueError:
            content = None
        if not isinstance(content, dict) or content.keys() != set(self._STATE):
            raise UsageError(f"expected a state of save_states, found {state!r:.80}")
        return content

    def render(self) -> Optional[Tuple[Any, ...]]:
        """A picture or a line of text of each environment, as the render mode says.

        A picture takes some milliseconds. Environments beyond `render_envs` have a black one, or an
        empty line.
        """
        if self.render_mode is None or not self._is_running:
            return None
        show = self.navigation.status if self.render_mode == "ansi" else self.navigation.picture
        frames: List[Any] = [show(self._row(index)) for index in range(self._shown)]
        blank: Any = "" if self.render_mode == "ansi" else np.zeros_like(frames[0])
        return (*frames, *[blank] * (self.num_envs - self._shown))

    def _repr_png_(self) -> Optional[bytes]:
        """The picture that a notebook shows: the first environments; None before a reset."""
        if not self._is_running:
            return None
        shown = range(min(self._shown, _IN_NOTEBOOKS))
        return side_by_side([self.navigation.picture(index)[::2, ::2] for index in shown])

    @property  # type: ignore[misc] # Gymnasium's may be set
    def np_random(self) -> Any:
        """The random numbers of each environment."""
        return tuple(self._generator(index) for index in range(self.num_envs))

    @property
    def np_random_seed(self) -> Any:
        """The seeds of these random numbers."""
        for index in range(self.num_envs):
            self._generator(index)
        return tuple(self._seeds)

    def close_extras(self, **kwargs: Any) -> None:
        """Ends all simulations.

        Args:
            kwargs: of `close`; without effect.
        """
        self._is_running = False
        self.navigation.close()

    def _drive(self, actions: FloatArray, restarted: BoolArray) -> Steps:
        """Makes a step in all environments but those that are reset instead."""
        rewards, terminated, truncated = self.navigation.step(actions, np.flatnonzero(~restarted))
        truncated |= ~restarted & (self.navigation.steps >= self._most_steps)
        return rewards, terminated, truncated

    def _are_over(self, ended: BoolArray) -> BoolArray:
        """The environments to reset, given the episodes that have ended in the step."""
        return ended

    def _make_navigation(self, settings: NavigationSettings, threads: int) -> Navigation:
        return Navigation(settings, self.num_envs, threads)

    def _spaces(self) -> Tuple[spaces.Box, Any]:
        """The spaces of the actions and observations of an environment."""
        return self.navigation.action_space, self.navigation.observation_space

    def _row(self, index: int) -> int:
        """The robot that a picture of an environment shows."""
        return index

    def _checked(self, actions: Any) -> FloatArray:
        """The actions of a step, cut to the limits.

        Raises:
            UsageError: they are not usable, or there cannot be a step before a reset.
        """
        if not self._is_running:
            raise UsageError("expected reset before step")
        checked = self.navigation.checked_actions(actions, self.action_space.shape or ())
        if self.autoreset_mode == AutoresetMode.DISABLED and self._ended.any():
            ended = np.flatnonzero(self._ended).tolist()
            raise UsageError(
                'expected reset(options={"reset_mask": ...}) of the environments in which '
                f"episodes have ended: {ended[:10]}"
            )
        return checked

    def _seed(self, seeds: Sequence[Optional[int]], indices: Sequence[int]) -> None:
        for index in indices:
            seed = seeds[index]
            if seed is not None:
                self._generators[index], self._seeds[index] = seeding.np_random(seed)

    def _generator(self, index: int) -> np.random.Generator:
        """The random numbers of an environment; made when they are first needed."""
        generator = self._generators[index]
        if generator is None:
            generator, self._seeds[index] = seeding.np_random()
            self._generators[index] = generator
        return generator

    def _begin(self, indices: Any, options: Mapping[str, Any]) -> None:
        generators = [self._generator(index) for index in indices.tolist()]
        self.navigation.reset(indices, generators, options)

    def _observations(self) -> Any:
        return self.navigation.formed(self._flat())

    def _flat(self) -> Float32Array:
        """Flat observations: a new array of a row for each environment."""
        return self.navigation.observe()

    def _infos(self, chosen: BoolArray) -> Dict[str, Any]:
        """Infos with the values of some environments, in the form of VectorEnv."""
        infos: Dict[str, Any] = {}
        others = None if chosen.all() else ~chosen
        for name, values in self.navigation.info().items():
            if others is not None:
                values[others] = 0
            infos[name], infos[f"_{name}"] = values, chosen.copy()
        return infos

    def _final(self, ended: BoolArray) -> Dict[str, Any]:
        """The last observations and infos of episodes that have ended."""
        rows = self._flat()
        observations = np.full(self.num_envs, None, dtype=object)
        for index in np.flatnonzero(ended):
            observations[index] = self.navigation.formed(rows[index].copy())
        return {
            "final_obs": observations,
            "_final_obs": ended.copy(),
            "final_info": self._infos(ended),
            "_final_info": ended.copy(),
        }

    def _chosen(self, mask: Any, name: str = "reset_mask") -> BoolArray:
        """The environments that a mask of this name chooses: all if it is None."""
        if mask is None:
            return np.ones(self.num_envs, dtype=bool)
        shape, kind = getattr(mask, "shape", None), getattr(mask, "dtype", None)
        if shape != (self.num_envs,) or kind != np.bool_ or not mask.any():
            raise UsageError(
                f"expected {name} as an array of {self.num_envs} booleans, one at least true; "
                f"found {mask!r:.80}"
            )
        if not self._is_running and not mask.all():
            raise UsageError("expected a reset of all environments before one of some")
        return np.array(mask)


def _mode(value: Any) -> AutoresetMode:
    try:
        return AutoresetMode(value)
    except ValueError:
        known = ", ".join(repr(mode.value) for mode in AutoresetMode)
        raise UsageError(f"expected autoreset_mode to be one of {known}, found {value!r}") from None


def _seeds(seed: Seeds, count: int) -> Sequence[Optional[int]]:
    """A seed or None for each environment."""
    if seed is None:
        return [None] * count
    is_list = isinstance(seed, (list, tuple, np.ndarray))
    seeds: List[Any] = list(seed) if is_list else [seed]  # type: ignore[arg-type]
    is_right = all(each is None or (is_whole(each) and each >= 0) for each in seeds)
    if not is_right or (is_list and len(seeds) != count):
        raise UsageError(
            f"expected seed to be None, a number of 0 or more, or {count} of these; "
            f"found {seed!r:.80}"
        )
    if is_list:
        return [None if each is None else int(each) for each in seeds]
    return [int(seeds[0]) + index for index in range(count)]
