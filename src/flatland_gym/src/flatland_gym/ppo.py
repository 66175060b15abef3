"""Proximal policy optimisation (Schulman et al., 2017) in NumPy, for vector environments.

With small networks, a framework's overhead takes most of the training time on two cores. NumPy is
enough for matrices of 64 x 64 and tens of thousands of rows at a time.
"""

import math
import time
from dataclasses import dataclass, fields
from typing import Any, Callable, Dict, List, Mapping, NamedTuple, Tuple

import numpy as np

from flatland2d import MissingPackageError, UsageError
from flatland_gym.mirror import Mirror
from flatland_gym.navigation_vector_env import NavigationVectorEnv
from flatland_gym.networks import Adam, Network
from flatland_gym.policy import Policy
from flatland_server import BoolArray, Float32Array, FloatArray

_LOG_TWO_PI = math.log(2.0 * math.pi)

_BAR = "{l_bar}{bar}| {n:.0f}/{total:.0f} {unit} [{elapsed}<{remaining}{postfix}]"


@dataclass(frozen=True)
class PpoSettings:
    """The parameters of a training.

    Attributes:
        rollout: steps of each environment between two updates.
        minibatch: rows of a gradient step.
        epochs: how often an update uses each row.
        learning_rate: at the beginning; it falls to a tenth of that.
        discount: of rewards, per step.
        trace: the lambda of generalised advantage estimation.
        clip: how far the ratio of probabilities may leave 1.
        entropy: weight of the policy's entropy.
        hidden: sizes of the hidden layers.
        log_std: of the actions at the beginning, in units of their limits.
        mirror: whether left and right are exchanged in half of the rows, as the mirror image of a
            motion is one as well; for robots with a lidar that looks to both sides alike.
    """

    rollout: int = 64
    minibatch: int = 1024
    epochs: int = 6
    learning_rate: float = 1e-3
    discount: float = 0.99
    trace: float = 0.95
    clip: float = 0.2
    entropy: float = 1e-3
    hidden: Tuple[int, ...] = (64, 64)
    log_std: float = -0.5
    mirror: bool = True

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> "PpoSettings":
        """Settings out of values by their names, as from a command.

        Raises:
            UsageError: one is unknown or wrong.
        """
        known: Dict[str, Any] = {each.name: each.default for each in fields(cls)}
        found: Dict[str, Any] = {}
        for name, value in values.items():
            if name not in known:
                raise UsageError(
                    f'the learner has no setting "{name}"; there are: {", ".join(known)}'
                )
            try:
                found[name] = _like(known[name], value)
            except (TypeError, ValueError, OverflowError):
                raise UsageError(
                    f"expected the learner's {name} as something like {known[name]}, found {value}"
                ) from None
        return cls(**found)


def _like(default: Any, value: Any) -> Any:
    """A value of the type of another one: a boolean, or finite, and whole numbers above 0.

    Raises:
        ValueError: it is none; also TypeError, OverflowError.
    """
    if isinstance(default, tuple):
        return tuple(_like(default[0], each) for each in value)
    if type(default) is bool and not isinstance(value, bool):
        raise ValueError
    found = type(default)(value)
    if not math.isfinite(found) or (type(default) is int and found < 1):
        raise ValueError
    return found


class Scale:
    """Normalises observations by their means and standard deviations so far.

    Args:
        size: of an observation.
    """

    _LEAST = 0.05  # standard deviation

    def __init__(self, size: int) -> None:
        self._count = 0
        self._mean, self._variance = np.zeros(size), np.zeros(size)
        self._set(np.zeros(size), np.ones(size))

    @property
    def is_known(self) -> bool:
        """True if it has learnt from rows."""
        return self._count > 0

    def of(self, rows: Float32Array) -> Float32Array:
        """Normalised observations."""
        return (rows - self._shift) / self._width

    def take(self, rows: Float32Array) -> None:
        """Learns from normalised observations; those before count as well."""
        mean = self._shift + self._width * rows.mean(axis=0, dtype=np.float64)
        variance = self._width**2 * rows.var(axis=0, dtype=np.float64)
        part = len(rows) / (self._count + len(rows))
        away = mean - self._mean
        self._mean += part * away
        self._variance += part * (variance - self._variance + (1.0 - part) * away**2)
        self._count += len(rows)
        self._set(self._mean, np.maximum(np.sqrt(self._variance), self._LEAST))

    def folded(
        self, weights: Float32Array, biases: Float32Array
    ) -> Tuple[Float32Array, Float32Array]:
        """A first layer for observations as they are."""
        scaled = weights / self._width[:, None]
        return scaled, biases - self._shift @ scaled

    def _set(self, shift: FloatArray, width: FloatArray) -> None:
        self._shift, self._width = shift.astype(np.float32), width.astype(np.float32)


class Progress(NamedTuple):
    """The state of a training, after an update."""

    steps: int
    """Environment steps so far, over all environments."""
    seconds: float
    """Time since the beginning [s]."""
    episodes: int
    """Number of episodes that have ended since the last update."""
    success: float
    """The fraction of these episodes that reached the goal; NaN without any."""
    reward: float
    """The mean return of these episodes; NaN without any."""


class TrainingInterrupted(KeyboardInterrupt):
    """Ctrl-C during a training.

    Args:
        policy: as it was then.
    """

    def __init__(self, policy: Policy) -> None:
        super().__init__()
        self.policy = policy


class _Rollout(NamedTuple):
    """A rollout of all environments: arrays of shape (steps, environments, ...)."""

    observations: Float32Array
    actions: Float32Array
    log_probabilities: Float32Array
    advantages: Float32Array
    returns: Float32Array


class Ppo:
    """Trains a policy.

    Args:
        env: with `autoreset_mode="SameStep"` and flat observations.
        settings: of the training.
        seed: of the environments, the networks and the exploration.
    """

    def __init__(
        self, env: NavigationVectorEnv, settings: PpoSettings = PpoSettings(), seed: int = 0
    ) -> None:
        if env.autoreset_mode.value != "SameStep" or not env.navigation.settings.flatten:
            raise UsageError('expected autoreset_mode="SameStep" and flatten=True')
        self._env = env
        self._settings = settings
        self._rng = np.random.default_rng(seed)
        (size,) = env.single_observation_space.shape or ()
        self._limits = env.single_action_space.high
        sizes = (size, *settings.hidden)
        self._actor = Network((*sizes, len(self._limits)), 0.01, self._rng)
        self._critic = Network((*sizes, 1), 1.0, self._rng)
        self._log_std = np.full(len(self._limits), settings.log_std, np.float32)
        parameters = [*self._actor.parameters, *self._critic.parameters, self._log_std]
        self._optimiser = Adam(parameters)
        self._rewards = np.zeros(env.num_envs)
        self._ended: List[Tuple[bool, float]] = []
        self._observations, _ = env.reset(seed=seed)
        self._scale = Scale(size)
        # A robot alone learns slower with normalised beams: they drown the goal.
        self._normalises = env.navigation.settings.neighbors > 0
        self._mirror = Mirror.of(env.navigation) if settings.mirror else None
        self._seed = seed

    def train(
        self,
        steps: int,
        seconds: float = math.inf,
        report: Callable[[Progress], None] = lambda progress: None,
        progress_bar: bool = False,
    ) -> Policy:
        """Trains for a number of steps of all environments together, or for a time.

        Args:
            steps: at least; ends after the update that reaches them.
            seconds: at most.
            report: called after each update.
            progress_bar: whether tqdm shows a bar: of the time, or of the steps if that has no end.

        Returns:
            The policy, without exploration.

        Raises:
            TrainingInterrupted: Ctrl-C.
        """
        started, done = time.monotonic(), 0
        bar = TrainingBar(steps, seconds) if progress_bar else None
        try:
            if self._normalises and not self._scale.is_known:
                self._learn_scale()
            while done < steps and time.monotonic() - started < seconds:
                spent = (time.monotonic() - started) / seconds if seconds < math.inf else 0.0
                part = min(max(done / steps, spent), 1.0)
                self._ended.clear()
                rollout = self._roll_out()
                self._update(rollout, self._settings.learning_rate * (1.0 - 0.9 * part))
                done += self._settings.rollout * self._env.num_envs
                elapsed = time.monotonic() - started
                means = np.mean(self._ended, axis=0) if self._ended else (math.nan, math.nan)
                now = Progress(done, elapsed, len(self._ended), float(means[0]), float(means[1]))
                report(now)
                if bar is not None:
                    bar.show(now)
        except KeyboardInterrupt:
            raise TrainingInterrupted(self.policy()) from None
        finally:
            if bar is not None:
                bar.close()
        return self.policy()

    def policy(self) -> Policy:
        """The policy as it is now."""
        layers = self._actor.weights, self._actor.biases
        weights, biases = ([array.copy() for array in arrays] for arrays in layers)
        weights[0], biases[0] = self._scale.folded(weights[0], biases[0])
        return self._env.navigation.policy(weights, biases)

    def _learn_scale(self) -> None:
        """Makes a rollout for the scale alone: at a reset all stand still."""
        self._take_scale(self._roll_out().observations)
        self._observations, _ = self._env.reset(seed=self._seed)
        self._rewards[:] = 0.0

    def _take_scale(self, observations: Float32Array) -> None:
        """Makes the scale learn from observations, and from their mirror images."""
        rows = observations.reshape(-1, observations.shape[-1])
        if self._mirror is not None:
            rows = np.concatenate([rows, self._mirror.observations(rows)])
        self._scale.take(rows)

    def _roll_out(self) -> _Rollout:
        """Collects a rollout of all environments."""
        settings, count = self._settings, self._env.num_envs
        shape = (settings.rollout, count)
        observations = np.empty((*shape, self._observations.shape[1]), np.float32)
        actions = np.empty((*shape, len(self._limits)), np.float32)
        log_probabilities, rewards, values, next_values = (
            np.empty(shape, np.float32) for _ in range(4)
        )
        ends = np.empty(shape, bool)
        std = np.exp(self._log_std)
        for step in range(settings.rollout):
            seen = observations[step] = self._scale.of(self._observations)
            mean = self._actor.forward(seen)[-1]
            noise = self._rng.standard_normal(mean.shape, dtype=np.float32)
            actions[step] = mean + std * noise
            log_probabilities[step] = (-0.5 * (noise**2 + _LOG_TWO_PI) - self._log_std).sum(axis=1)
            values[step] = self._critic.forward(seen)[-1][:, 0]
            self._observations, rewards[step], terminated, truncated, infos = self._env.step(
                np.clip(actions[step], -1.0, 1.0) * self._limits
            )
            ends[step] = terminated | truncated
            next_values[step] = self._values_after(terminated, ends[step], infos)
            self._note(rewards[step], ends[step], infos)
        advantages = _advantages(rewards, values, next_values, ends, settings)
        return _Rollout(observations, actions, log_probabilities, advantages, advantages + values)

    def _values_after(self, terminated: BoolArray, ended: BoolArray, infos: dict) -> Float32Array:  # type: ignore[type-arg]
        """The values of the observations after a step; 0 where the episode has terminated.

        A truncated episode is not over for the value function: its last observation has a value.
        """
        last = self._observations
        if ended.any():
            last = last.copy()
            for index in np.flatnonzero(ended):
                last[index] = infos["final_obs"][index]
        values: Float32Array = np.where(
            terminated, 0.0, self._critic.forward(self._scale.of(last))[-1][:, 0]
        )
        return values

    def _note(self, rewards: Float32Array, ended: BoolArray, infos: dict) -> None:  # type: ignore[type-arg]
        """Keeps the results of episodes, for reports."""
        self._rewards += rewards
        for index in np.flatnonzero(ended):
            success = bool(infos["final_info"]["success"][index])
            self._ended.append((success, float(self._rewards[index])))
            self._rewards[index] = 0.0

    def _update(self, rollout: _Rollout, rate: float) -> None:
        """Updates the policy by a rollout."""
        flat = _Rollout(*(each.reshape(-1, *each.shape[2:]) for each in rollout))
        size, minibatch = len(flat.actions), self._settings.minibatch
        for _ in range(self._settings.epochs):
            order = self._rng.permutation(size)
            for start in range(0, size, minibatch):
                chosen = order[start : start + minibatch]
                rows = _Rollout(*(each[chosen] for each in flat))
                if self._mirror is not None:
                    half = len(chosen) // 2
                    self._mirror.turn(rows.observations[:half], rows.actions[:half])
                self._descend(rows, rate)
        if self._normalises:
            self._take_scale(flat.observations)

    def _descend(self, rows: _Rollout, rate: float) -> None:
        """Makes a step of the optimiser: the gradients of PPO's clipped objective."""
        settings, count = self._settings, np.float32(len(rows.actions))
        advantages = (rows.advantages - rows.advantages.mean()) / (rows.advantages.std() + 1e-8)
        outputs = self._actor.forward(rows.observations)
        std = np.exp(self._log_std)
        z = (rows.actions - outputs[-1]) / std
        log_probabilities = (-0.5 * (z**2 + _LOG_TWO_PI) - self._log_std).sum(axis=1)
        ratio = np.exp(np.clip(log_probabilities - rows.log_probabilities, -20.0, 20.0))
        is_clipped = ((advantages > 0) & (ratio > 1 + settings.clip)) | (
            (advantages < 0) & (ratio < 1 - settings.clip)
        )
        towards = np.where(is_clipped, 0.0, -advantages * ratio).astype(np.float32)[:, None] / count
        actor = self._actor.backward(outputs, towards * z / std)
        log_std = (towards * (z**2 - 1.0)).sum(axis=0) - np.float32(settings.entropy)
        values = self._critic.forward(rows.observations)
        error = (values[-1][:, 0] - rows.returns)[:, None] * np.float32(0.5) / count
        critic = self._critic.backward(values, error.astype(np.float32))
        self._optimiser.step([*actor, *critic, log_std], rate)


class TrainingBar:
    """A bar of tqdm, for a terminal or a notebook: of the time, or of the steps without a limit.

    Args:
        steps: to train at most.
        seconds: to train at most.

    Raises:
        MissingPackageError: tqdm is not installed.
    """

    def __init__(self, steps: int, seconds: float) -> None:
        try:
            from tqdm.auto import tqdm
        except ImportError:
            raise MissingPackageError("a progress bar needs tqdm: pip install tqdm") from None
        self._is_timed = seconds < math.inf
        self._bar = tqdm(
            total=seconds if self._is_timed else steps,
            unit="s" if self._is_timed else "steps",
            bar_format=_BAR,
        )

    def show(self, now: Progress) -> None:
        """Shows the progress."""
        bar = self._bar
        bar.set_postfix_str(f"{now.steps} steps, success {now.success:.1%}", refresh=False)
        bar.update(min(now.seconds if self._is_timed else now.steps, bar.total) - bar.n)

    def close(self) -> None:
        """Leaves the bar as it is."""
        self._bar.close()


def _advantages(
    rewards: Float32Array,
    values: Float32Array,
    next_values: Float32Array,
    ends: BoolArray,
    settings: PpoSettings,
) -> Float32Array:
    """Generalised advantage estimation (Schulman et al., 2016); shape (steps, environments)."""
    advantages = np.empty_like(rewards)
    following: FloatArray = np.zeros(rewards.shape[1])
    for step in range(len(rewards) - 1, -1, -1):
        error = rewards[step] + settings.discount * next_values[step] - values[step]
        following = error + settings.discount * settings.trace * ~ends[step] * following
        advantages[step] = following
    return advantages
