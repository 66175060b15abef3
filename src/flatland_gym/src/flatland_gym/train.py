"""Trains a policy without PyTorch: `python3 -m flatland_gym.train --world discs policy.npz`.

Proximal policy optimisation (Schulman et al., 2017) in NumPy, for vector environments: with
networks of 64 x 64, a framework's overhead takes most of the time on two cores. Its few settings
are those below. Other networks, schedules and algorithms are Stable-Baselines3's: docs/learners.md.
"""

import argparse
import math
import os
import sys
import time
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any, Callable, Dict, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from flatland2d import FlatlandError, UsageError
from flatland2d.cli.arguments import INTERRUPTED, pair, positive, whole_from
from flatland2d.sweep.intervals import rate
from flatland_gym.observations import mirror_signs
from flatland_gym.policy import Policy, layer_values
from flatland_server import Float32Array, FloatArray

if TYPE_CHECKING:  # they need Gymnasium, the absence of which `main` reports
    from flatland_gym.evaluation import Evaluation
    from flatland_gym.navigation import Navigation
    from flatland_gym.navigation_vector_env import NavigationVectorEnv
    from flatland_gym.robot import Robot

_ROLLOUT = 64  # steps of each environment between two updates
_MINIBATCH = 1024  # rows of a gradient step
_EPOCHS = 6  # how often an update uses each row
_TRACE = 0.95  # the lambda of generalised advantage estimation
_CLIP = 0.2  # of the ratio of probabilities
_ENTROPY = np.float32(1e-3)  # weight of the policy's entropy
_HIDDEN = (64, 64)
_LOG_STD = -0.5  # of the actions at the beginning, in units of their limits
_MAX_NORM = 0.5  # of all gradients together
_LEAST_WIDTH = 0.05  # standard deviation of a normalised observation
_LOG_TWO_PI = math.log(2.0 * math.pi)

_FIRST_UNSEEN = 1_000_000  # seed of an evaluation; those of training are below

Arrays = List[Float32Array]


class Progress(NamedTuple):
    """The state of a training, after an update.

    Attributes:
        steps: of all environments together, so far.
        seconds: since the beginning.
        success: the part of the episodes since the last update that reached the goal; NaN without.
    """

    steps: int
    seconds: float
    success: float


class Rollout(NamedTuple):
    """Rows of experience: arrays of shape (steps, environments, ...), or (rows, ...)."""

    observations: Float32Array
    actions: Float32Array
    log_probabilities: Float32Array
    advantages: Float32Array
    returns: Float32Array


class Ppo:
    """Trains a policy.

    If the lidar looks to both sides alike, left and right are exchanged in half of the rows.

    Args:
        env: with `autoreset_mode="SameStep"` and flat observations.
        seed: of the environments, the networks and the exploration.
        learning_rate: at the beginning; it falls to a tenth of that.
        discount: of rewards, per step.

    Raises:
        UsageError: the environments or a setting cannot be used.
    """

    def __init__(
        self,
        env: "NavigationVectorEnv",
        seed: int = 0,
        learning_rate: float = 1e-3,
        discount: float = 0.99,
    ) -> None:
        if env.autoreset_mode.value != "SameStep" or not env.navigation.settings.flatten:
            raise UsageError('expected autoreset_mode="SameStep" and flatten=True')
        if not (0.0 < learning_rate < math.inf and 0.0 <= discount <= 1.0):
            raise UsageError(
                "expected a learning_rate above 0 and a discount of 0 to 1, found "
                f"{learning_rate} and {discount}"
            )
        env.navigation.require_standard()
        self._env, self._seed = env, seed
        self._rate, self._discount = learning_rate, discount
        self._rng = np.random.default_rng(seed)
        (size,) = env.single_observation_space.shape or ()
        self._limits = env.single_action_space.high
        self._actor = Network((size, *_HIDDEN, len(self._limits)), 0.01, self._rng)
        self._critic = Network((size, *_HIDDEN, 1), 1.0, self._rng)
        self._log_std = np.full(len(self._limits), _LOG_STD, np.float32)
        parameters = [*self._actor.parameters, *self._critic.parameters, self._log_std]
        self._optimiser = Adam(parameters)
        self._successes: List[float] = []
        self._observations, _ = env.reset(seed=seed)
        self._scale = Scale(size)
        # A robot alone learns slower with normalised beams: they drown the goal.
        self._normalises = env.navigation.settings.neighbors > 0
        self._mirror = Mirror.of(env.navigation)

    def train(
        self,
        steps: int,
        seconds: float = math.inf,
        report: Callable[[Progress], None] = lambda progress: None,
    ) -> Policy:
        """Trains for a number of steps of all environments together, or for a time.

        Args:
            steps: at least; ends after the update that reaches them.
            seconds: longest time of the training [s].
            report: called after each update.

        Returns:
            The policy, without exploration.
        """
        started, done = time.monotonic(), 0
        if self._normalises and not self._scale.count:  # at a reset all stand still
            self._take_scale(self._roll_out().observations)
            self._observations, _ = self._env.reset(seed=self._seed)
        while done < steps and time.monotonic() - started < seconds:
            spent = (time.monotonic() - started) / seconds if seconds < math.inf else 0.0
            part = min(max(done / steps, spent), 1.0)
            self._successes.clear()
            self._update(self._roll_out(), self._rate * (1.0 - 0.9 * part))
            done += _ROLLOUT * self._env.num_envs
            success = float(np.mean(self._successes or [math.nan]))
            report(Progress(done, time.monotonic() - started, success))
        return self.policy()

    def policy(self) -> Policy:
        """The policy as it is now."""
        layers = self._actor.weights, self._actor.biases
        weights, biases = ([array.copy() for array in arrays] for arrays in layers)
        weights[0], biases[0] = self._scale.folded(weights[0], biases[0])
        return self._env.navigation.policy(weights, biases)

    def _take_scale(self, observations: Float32Array) -> None:
        """Makes the scale learn from observations, and from their mirror images."""
        rows = observations.reshape(-1, observations.shape[-1])
        if self._mirror is not None:
            rows = np.concatenate([rows, self._mirror.observations(rows)])
        self._scale.take(rows)

    def _roll_out(self) -> Rollout:
        """Collects a rollout of all environments."""
        shape = (_ROLLOUT, self._env.num_envs)
        observations = np.empty((*shape, self._observations.shape[1]), np.float32)
        actions = np.empty((*shape, len(self._limits)), np.float32)
        log_probabilities, rewards, values, next_values = np.empty((4, *shape), np.float32)
        ends = np.empty(shape, bool)
        std = np.exp(self._log_std)
        for step in range(_ROLLOUT):
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
            last = self._observations.copy()
            for index in np.flatnonzero(ends[step]):
                last[index] = infos["final_obs"][index]
                self._successes.append(bool(infos["final_info"]["success"][index]))
            # A truncated episode is not over for the value function.
            after = self._critic.forward(self._scale.of(last))[-1][:, 0]
            next_values[step] = np.where(terminated, 0.0, after)
        errors = rewards + self._discount * next_values - values
        advantages = _sums(errors, self._discount * _TRACE * ~ends)
        return Rollout(observations, actions, log_probabilities, advantages, advantages + values)

    def _update(self, rollout: Rollout, rate: float) -> None:
        """Updates the policy by a rollout."""
        flat = Rollout(*(each.reshape(-1, *each.shape[2:]) for each in rollout))
        for _ in range(_EPOCHS):
            order = self._rng.permutation(len(flat.actions))
            for start in range(0, len(order), _MINIBATCH):
                chosen = order[start : start + _MINIBATCH]
                rows = Rollout(*(each[chosen] for each in flat))
                if self._mirror is not None:
                    half = len(chosen) // 2
                    self._mirror.turn(rows.observations[:half], rows.actions[:half])
                self._descend(rows, rate)
        if self._normalises:
            self._take_scale(flat.observations)

    def _descend(self, rows: Rollout, rate: float) -> None:
        """Makes a step of the optimiser: the gradients of PPO's clipped objective."""
        count = np.float32(len(rows.actions))
        advantages = (rows.advantages - rows.advantages.mean()) / (rows.advantages.std() + 1e-8)
        outputs = self._actor.forward(rows.observations)
        std = np.exp(self._log_std)
        z = (rows.actions - outputs[-1]) / std
        log_probabilities = (-0.5 * (z**2 + _LOG_TWO_PI) - self._log_std).sum(axis=1)
        ratio = np.exp(np.clip(log_probabilities - rows.log_probabilities, -20.0, 20.0))
        is_clipped = np.where(advantages > 0, ratio > 1 + _CLIP, ratio < 1 - _CLIP)
        towards = np.where(is_clipped, 0.0, -advantages * ratio).astype(np.float32)[:, None] / count
        actor = self._actor.backward(outputs, towards * z / std)
        log_std = (towards * (z**2 - 1.0)).sum(axis=0) - _ENTROPY
        values = self._critic.forward(rows.observations)
        error = (values[-1][:, 0] - rows.returns)[:, None] * np.float32(0.5) / count
        critic = self._critic.backward(values, error.astype(np.float32))
        self._optimiser.step([*actor, *critic, log_std], rate)


def _sums(errors: Float32Array, factors: FloatArray) -> Float32Array:
    """Generalised advantage estimation (Schulman et al., 2016); shape (steps, environments)."""
    advantages = np.empty_like(errors)
    following: FloatArray = np.zeros(errors.shape[1])
    for step in range(len(errors) - 1, -1, -1):
        advantages[step] = following = errors[step] + factors[step] * following
    return advantages


class Network:
    """Layers with tanh between them.

    Args:
        sizes: of the input, of each hidden layer, and of the output.
        gain: scale of the last layer's initial weights.
        rng: draws the initial weights: orthogonal, which is known to help PPO.
    """

    def __init__(self, sizes: Sequence[int], gain: float, rng: np.random.Generator) -> None:
        gains = [math.sqrt(2.0)] * (len(sizes) - 2) + [gain]
        self.weights: Arrays = [
            (scale * _orthogonal(rows, columns, rng)).astype(np.float32)
            for scale, rows, columns in zip(gains, sizes[:-1], sizes[1:])
        ]
        self.biases: Arrays = [np.zeros(columns, np.float32) for columns in sizes[1:]]

    @property
    def parameters(self) -> Arrays:
        """Weights and biases, to be changed in place."""
        return [*self.weights, *self.biases]

    def forward(self, inputs: Float32Array) -> Arrays:
        """The inputs and the outputs of all layers: shape (n, size) each."""
        return layer_values(self.weights, self.biases, inputs)

    def backward(self, values: Arrays, gradient: Float32Array) -> Arrays:
        """The gradients of the parameters, in their order.

        Args:
            values: what `forward` has returned for the inputs.
            gradient: of the output, shape (n, size).
        """
        weights: Arrays = []
        biases: Arrays = []
        for number in range(len(self.weights) - 1, -1, -1):
            weights.insert(0, values[number].T @ gradient)
            biases.insert(0, gradient.sum(axis=0))
            if number:
                gradient = (gradient @ self.weights[number].T) * (1.0 - values[number] ** 2)
        return [*weights, *biases]


def _orthogonal(rows: int, columns: int, rng: np.random.Generator) -> Float32Array:
    """A matrix with orthonormal rows or columns."""
    matrix = rng.normal(size=(max(rows, columns), min(rows, columns)))
    q, r = np.linalg.qr(matrix)
    q *= np.sign(np.diag(r))
    return q if rows >= columns else q.T  # type: ignore[no-any-return]


class Adam:
    """Adam (Kingma and Ba, 2015), with the gradients' common norm limited.

    Args:
        parameters: the parameters; `step` changes them in place.
    """

    def __init__(self, parameters: Arrays) -> None:
        self._parameters = parameters
        self._means = [np.zeros_like(each) for each in parameters]
        self._squares = [np.zeros_like(each) for each in parameters]
        self._count = 0

    def step(self, gradients: Arrays, rate: float) -> None:
        """Makes a step of gradient descent."""
        self._count += 1
        norm = float(np.sqrt(sum(float((each**2).sum()) for each in gradients)))
        factor = np.float32(min(1.0, _MAX_NORM / (norm + 1e-8)))
        correction = np.sqrt(1.0 - 0.999**self._count) / (1.0 - 0.9**self._count)
        for parameter, gradient, mean, square in zip(
            self._parameters, gradients, self._means, self._squares
        ):
            scaled = gradient * factor
            mean += np.float32(0.1) * (scaled - mean)
            square += np.float32(0.001) * (scaled * scaled - square)
            parameter -= np.float32(rate * correction) * mean / (np.sqrt(square) + np.float32(1e-8))


class Scale:
    """Normalises observations by their means and standard deviations so far.

    Args:
        size: length of an observation.
    """

    def __init__(self, size: int) -> None:
        self.count = 0
        self._mean, self._variance = np.zeros(size), np.zeros(size)
        self._shift, self._width = np.zeros(size, np.float32), np.ones(size, np.float32)

    def of(self, rows: Float32Array) -> Float32Array:
        """Normalised observations."""
        return (rows - self._shift) / self._width

    def take(self, rows: Float32Array) -> None:
        """Learns from normalised observations; those before count as well."""
        mean = self._shift + self._width * rows.mean(axis=0, dtype=np.float64)
        variance = self._width**2 * rows.var(axis=0, dtype=np.float64)
        part = len(rows) / (self.count + len(rows))
        away = mean - self._mean
        self._mean += part * away
        self._variance += part * (variance - self._variance + (1.0 - part) * away**2)
        self.count += len(rows)
        self._shift = self._mean.astype(np.float32)
        self._width = np.maximum(np.sqrt(self._variance), _LEAST_WIDTH).astype(np.float32)

    def folded(
        self, weights: Float32Array, biases: Float32Array
    ) -> Tuple[Float32Array, Float32Array]:
        """A first layer for observations as they are."""
        scaled = weights / self._width[:, None]
        return scaled, biases - self._shift @ scaled


class Mirror:
    """Mirror images of a robot's experience, in which left and right change places.

    The mirror image of a motion is a motion as well: a learner has twice the experience from the
    same steps (Abdolhosseini et al., "On learning symmetric locomotion", MIG 2019).

    Args:
        robot: with `mirrored_beams`.
        neighbors: number of neighbours in an observation.
    """

    def __init__(self, robot: "Robot", neighbors: int) -> None:
        self.signs = mirror_signs(robot.beams, robot.velocity_limits, neighbors)
        self.order = np.arange(len(self.signs))
        self.order[: robot.beams] = robot.mirrored_beams
        self.action_signs = np.full(len(robot.action_limits), -1.0, np.float32)
        self.action_signs[0] = 1.0  # the speed forwards

    @classmethod
    def of(cls, navigation: "Navigation") -> "Optional[Mirror]":
        """The mirror images of an environment; None if the lidar is not left-right symmetric.

        Raises:
            UsageError: its observations are of a user's own parts.
        """
        navigation.require_standard()
        robot = navigation.robot
        return cls(robot, navigation.settings.neighbors) if robot.mirrored_beams else None

    def observations(self, rows: Float32Array) -> Float32Array:
        """The mirror images of flat observations, shape (n, size)."""
        images: Float32Array = rows[:, self.order]
        images *= self.signs
        return images

    def turn(self, observations: Float32Array, actions: Float32Array) -> None:
        """Replaces rows by their mirror images."""
        observations[:] = self.observations(observations)
        actions *= self.action_signs


def main(arguments: Optional[List[str]] = None) -> int:
    """Trains, evaluates and saves a policy; returns an exit code."""
    try:
        return _train(_parser().parse_args(arguments))
    except (FlatlandError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1


def _train(options: argparse.Namespace) -> int:
    from flatland_gym import NavigationVectorEnv  # or says that Gymnasium is missing
    from flatland_gym.evaluation import StraightDriver, evaluate

    settings: Dict[str, Any] = {"world": options.world, "frame_skip": 2, "time_limit": 30.0}
    settings.update(options.set)
    progress: List[Progress] = []

    def report(now: Progress) -> None:
        progress.append(now)
        if len(progress) % 20 == 0:
            found = [each.success for each in progress[-20:] if each.success >= 0.0]
            success = 100.0 * np.mean(found or [math.nan])
            line = f"{now.steps:>9} steps  {now.seconds:6.0f} s  success {success:5.1f} %"
            print(line, flush=True)

    begin = time.process_time()
    vector = {"num_envs": options.envs, "threads": options.threads, "autoreset_mode": "SameStep"}
    with closing(NavigationVectorEnv(**vector, **settings)) as env:
        learner = Ppo(env, options.seed, options.learning_rate, options.discount)
        options.policy.open("ab").close()  # it can be written, as is known before the training
        try:
            policy = learner.train(options.steps, 60.0 * options.minutes, report)
        except KeyboardInterrupt:
            learner.policy().save(options.policy)
            steps = progress[-1].steps if progress else 0
            print(f"{options.policy}: interrupted after {steps} steps", file=sys.stderr)
            return INTERRUPTED
    policy.save(options.policy)
    used = time.process_time() - begin
    print(f"trained: {progress[-1].steps} steps, {used:.0f} s of processor time")
    seeds = range(_FIRST_UNSEEN, _FIRST_UNSEEN + options.episodes)
    result = evaluate(policy, seeds, options.threads, **settings)
    print(f"{options.policy}: {_rates(result)}, of {options.episodes} episodes with new seeds")
    straight = StraightDriver(policy.beams, len(policy.action_limits))
    print(f"straight at the goal: {_rates(evaluate(straight, seeds, options.threads, **settings))}")
    return 0


def _rates(result: "Evaluation") -> str:
    """The rates of an evaluation, with intervals of 95 % confidence."""
    parts = []
    for name, found in (("success", result.success), ("collisions", result.collision)):
        part, low, high = (100.0 * value for value in rate(int(found.sum()), len(found)))
        parts.append(f"{name} {part:.1f} % ({low:.1f} to {high:.1f})")
    return ", ".join(parts)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python3 -m flatland_gym.train", description="Trains a policy by PPO."
    )
    add = parser.add_argument
    add("policy", type=Path, help="the file to write: .npz")
    add("--world", default="discs", help="a scenario, a shipped world or a file (default: discs)")
    add("--minutes", type=positive, default=4.0, help="to train at most (default: 4)")
    many = 10**9
    add("--steps", type=whole_from(1), default=many, help="to train at most, of all environments")
    add("--seed", type=whole_from(0), default=1, help="of all random numbers (default: 1)")
    add("--envs", type=whole_from(1), default=128, help="environments at a time (default: 128)")
    add("--threads", type=whole_from(1), default=2, help="that step them (default: 2)")
    add("--episodes", type=whole_from(1), default=200, help="of the evaluation (default: 200)")
    add("--learning-rate", type=float, default=1e-3, help="at the beginning (default: 0.001)")
    add("--discount", type=float, default=0.99, help="of rewards, per step (default: 0.99)")
    add(
        "--set",
        type=pair,
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="another argument of the environment, in YAML: --set lidar=front --set beams=32",
    )
    return parser


def _limit_blas_threads() -> None:
    """Starts this program again with one thread for NumPy's products, unless the user has chosen.

    The products are small, and threads that wait for each other are slow on a busy machine: five
    times as slow with twice as many running processes as cores. OpenBLAS reads the variable when
    NumPy loads it.
    """
    if "OPENBLAS_NUM_THREADS" not in os.environ:
        os.environ["OPENBLAS_NUM_THREADS"] = "1"
        os.execv(sys.executable, [sys.executable, "-m", "flatland_gym.train", *sys.argv[1:]])


if __name__ == "__main__":
    _limit_blas_threads()
    sys.exit(main())
