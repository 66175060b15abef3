"""Rewards and terminations of navigation: pure functions of arrays."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Callable, NamedTuple, Tuple

from flatland_server import BoolArray, Float32Array, FloatArray


class OtherModels:
    """All models but the robots, in n environments; read from the simulation when asked for.

    Columns that an episode does not use are far away, and models that are in other worlds alone are
    NaN.

    Args:
        names: of the models, m.
        read: returns their poses and velocities, shape (n, m, 3) each.

    Attributes:
        names: of the models, in the order of the arrays.
    """

    def __init__(
        self, names: Tuple[str, ...], read: Callable[[], Tuple[FloatArray, FloatArray]]
    ) -> None:
        self.names = names
        self._read = read

    @cached_property
    def _motions(self) -> Tuple[FloatArray, FloatArray]:
        return self._read()

    @property
    def poses(self) -> FloatArray:
        """x, y [m] and yaw [rad] in the world, shape (n, m, 3)."""
        return self._motions[0]

    @property
    def velocities(self) -> FloatArray:
        """vx, vy [m/s] and omega [rad/s] in the world's frame, shape (n, m, 3)."""
        return self._motions[1]


class Transition(NamedTuple):
    """A step of n environments, for functions that replace the reward or the termination.

    Arrays are read-only, and valid during the call.
    """

    previous_distance: FloatArray
    """Distance from the robot to the goal before the step [m], shape (n,)."""
    distance: FloatArray
    """The same distance after the step [m], shape (n,)."""
    success: BoolArray
    """True where the goal is reached, without a collision: shape (n,)."""
    collision: BoolArray
    """True where the robot has touched something in this step: shape (n,)."""
    actions: FloatArray
    """Commands of the drives: shape (n, size of an action)."""
    poses: FloatArray
    """Poses of the robots: x, y [m] and yaw [rad] in the world, shape (n, 3)."""
    velocities: FloatArray
    """Velocities forwards, to the left and turning [m/s, m/s, rad/s], shape (n, 3)."""
    goals: FloatArray
    """Goals: x, y [m] in the world, shape (n, 2)."""
    ranges: Float32Array
    """Ranges of the lidar [m], +inf for no return: float32, shape (n, beams)."""
    period: float
    """Length of the step [s]."""
    models: "OtherModels"
    """The other models of the world, at the end of the step."""


@dataclass(frozen=True)
class RewardWeights:
    """Weights of the parts of the reward.

    Attributes:
        progress: per metre by which the goal has come nearer.
        success: once, when it is reached.
        collision: for each step in which the robot touches something.
        time: per second.
    """

    progress: float = 1.0
    success: float = 10.0
    collision: float = -10.0
    time: float = -0.1

    def reward(self, progress: Any, success: Any, collision: Any, period: float) -> Any:
        """The reward of a step: of numbers, or of arrays.

        Args:
            progress: by which the goal has come nearer [m].
            success: whether the goal is reached.
            collision: whether the robot has touched something.
            period: length of the step [s].
        """
        events = self.success * success + self.collision * collision
        return self.progress * progress + events + self.time * period


def navigation_reward(step: Transition, weights: RewardWeights) -> FloatArray:
    """The reward of a step: progress, success, collision and time; shape (n,).

    Args:
        step: a step of n environments.
        weights: weights of the parts of the reward.
    """
    reward: FloatArray = weights.reward(
        step.previous_distance - step.distance, step.success, step.collision, step.period
    )
    return reward


def navigation_termination(step: Transition, collision_ends: bool) -> BoolArray:
    """True where the goal is reached, or the robot has collided; shape (n,)."""
    return step.success | step.collision if collision_ends else step.success
