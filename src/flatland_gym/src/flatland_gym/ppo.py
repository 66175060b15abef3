"""Proximal policy optimisation (Schulman et al., 2017) in NumPy, for vector environments.

With small networks, a framework's overhead takes most of the training time on two cores. NumPy is
enough for matrices of 64 x 64 and tens of thousands of rows at a time.
"""

import math
import time
from typing import Callable, List, NamedTuple, Tuple

import numpy as np

from flatland2d import UsageError
from flatland_gym.mirror import Mirror
from flatland_gym.navigation_vector_env import NavigationVectorEnv
from flatland_gym.networks import Adam, Network, Scale
from flatland_gym.policy import Policy
from flatland_gym.ppo_settings import PpoSettings
from flatland_gym.training_progress import Progress, TrainingBar, TrainingInterrupted
from flatland_server import BoolArray, Float32Array, FloatArray

_LOG_TWO_PI = math.log(2.0 * math.pi)


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
