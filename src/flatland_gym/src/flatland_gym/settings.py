"""Settings of a navigation environment: all arguments of `gym.make`, checked in one place."""

import math
import sys
from dataclasses import dataclass, field, fields
from typing import Any, Callable, Mapping, Optional, Sequence, Tuple, Union

import numpy as np

from flatland2d import UsageError
from flatland2d.batch.variation import ranges_of
from flatland_gym.rewards import RewardWeights, Transition
from flatland_server.exceptions import UnknownArgumentError, suggestion

WorldName = Any
"""The name of a scenario or of a shipped world, the path of a world file, or its content."""

_MOST = 10_000
"""Columns in an environment, and neighbours in an observation: more are a slip, and fill memory."""


@dataclass(frozen=True)
class NavigationSettings:
    """The arguments of `gym.make("flatland/Navigation-v0", ...)`, all of them optional.

    Attributes:
        world: a scenario of `flatland_gym.SCENARIOS`, a shipped world, a path, or a dict; or a
            sequence of these, of which each episode draws one.
        robot: the model that is driven; by default the only one with a drive and a lidar.
        lidar: the name of its lidar, if it has several.
        beams: number of beams, evenly over the angle of its lidar; None leaves them as they are.
        neighbors: number of the nearest other models that are observed, with velocities.
        neighbor_range: the largest gap at which they are observed [m]; None: the lidar's range.
        neighbor_noise: standard deviation of their positions [m] and velocities [m/s], along each
            axis.
        neighbors_behind_walls: whether models are observed that a wall hides from the robot.
        step_size: of the physics [s].
        frame_skip: physics steps in a step of the environment.
        flatten: whether observations are one array, or a dict of ranges, goal and velocity.
        observation: a part, or a sequence of parts, in place of ranges, goal, velocity and
            neighbours: names of `flatland_gym.parts.OURS`, a `MapCrop`, an `ObservationPart`, or a
            function of a `Situation`, which returns an array of shape (n, ...).
        privileged: the same for `info["privileged"]`, one array: what a critic may know.
        goal_radius: how near to the goal is a success [m].
        goal_distance: the least and the largest distance between start and goal [m].
        margin: between the robot and walls or other models, at the start and at the goal [m].
        time_limit: of an episode [s]; reaching it truncates. Infinite: there is none.
        collision_ends: whether a collision terminates the episode.
        rewards: weights of the parts of the reward; given as such, or as a dict of some of them.
        reward: replaces the reward; gets a `Transition`, returns an array of shape (n,).
        terminated: replaces the condition of termination; gets a `Transition`, returns booleans.
        speed_limit: of the actions, where the drive has no velocity limit of its own [m/s].
        yaw_rate_limit: the same for turning [rad/s].
        steer_limit: the same for the front wheel of a TricycleDrive or an AckermannDrive [rad].
        obstacles: how many columns are added to the world: a number, or the least and the largest
            number of an episode.
        obstacle_radius: the least and the largest radius of these [m].
        scatter: name patterns ("box_*") of models that each episode places at random; None: those
            of the scenario.
        lidar_noise: standard deviation of the ranges [m]; None leaves the lidar as it is.
        robot_scales: sizes of the robot's footprints, relative to the world's; each episode draws
            one.
        vary: numbers of model files that each episode draws: the least and the greatest value of
            each, by names such as "turtlebot/laser/range"; see `SimulationBatch`.
        params: parameters for expressions in the world's files, by absolute name.
        maps: makes the walls of map k, which are in the place of those of the world's first layer:
            a function of `numpy.random.default_rng(k)` that returns them, shape (n, 4), x1, y1, x2,
            y2 [m]; such as `Rooms`. Each episode draws a map.
        num_maps: how many maps there are, from number 0 on.
    """

    world: Union[WorldName, Sequence[WorldName]] = "office"
    robot: Optional[str] = None
    lidar: Optional[str] = None
    beams: Optional[int] = None
    neighbors: int = 0
    neighbor_range: Optional[float] = None
    neighbor_noise: float = 0.0
    neighbors_behind_walls: bool = False
    step_size: float = 0.05
    frame_skip: int = 1
    flatten: bool = True
    observation: Any = None
    privileged: Any = None
    goal_radius: float = 0.3
    goal_distance: Tuple[float, float] = (1.0, 10.0)
    margin: float = 0.1
    time_limit: float = 60.0
    collision_ends: bool = True
    rewards: RewardWeights = field(default_factory=RewardWeights)
    reward: Optional[Callable[[Transition], Any]] = None
    terminated: Optional[Callable[[Transition], Any]] = None
    speed_limit: float = 1.0
    yaw_rate_limit: float = 2.0
    steer_limit: float = 1.0
    obstacles: Union[int, Tuple[int, int]] = 0
    obstacle_radius: Tuple[float, float] = (0.15, 0.4)
    scatter: Optional[Sequence[str]] = None
    lidar_noise: Optional[float] = None
    robot_scales: Sequence[float] = (1.0,)
    vary: Mapping[str, Tuple[float, float]] = field(default_factory=dict)
    params: Mapping[str, Any] = field(default_factory=dict)
    maps: Optional[Callable[[np.random.Generator], Any]] = None
    num_maps: int = 1_000_000

    def __post_init__(self) -> None:
        """Raises a UsageError for a value that is not usable."""
        for name in ("frame_skip", "beams"):
            value = getattr(self, name)
            if not (value is None and name == "beams"):
                _require(name, value, is_whole(value) and value >= 1, "a whole number above 0")
        is_count = is_whole(self.neighbors) and 0 <= self.neighbors <= _MOST
        _require("neighbors", self.neighbors, is_count, f"a whole number of 0 to {_MOST}")
        is_number = is_whole(self.num_maps) and self.num_maps >= 1
        _require("num_maps", self.num_maps, is_number, "a whole number above 0")
        is_function = self.maps is None or callable(self.maps)
        _require("maps", self.maps, is_function, "a function that makes walls")
        if self.maps is not None and len(self.worlds) * len(self.robot_scales) > 1:
            raise UsageError("expected one world and one size of the robot with maps")
        _require("world", self.world, self.worlds, "a world, or one at least in a sequence")
        for name in ("step_size", "goal_radius", "speed_limit", "yaw_rate_limit", "steer_limit"):
            _require_number(name, getattr(self, name), above=0.0)
        if self.time_limit != math.inf:
            _require_number("time_limit", self.time_limit, above=0.0)
        _require_number("margin", self.margin, minimum=0.0)
        _require_number("neighbor_noise", self.neighbor_noise, minimum=0.0)
        if self.neighbor_range is not None:
            _require_number("neighbor_range", self.neighbor_range, above=0.0)
        if self.lidar_noise is not None:
            _require_number("lidar_noise", self.lidar_noise, minimum=0.0)
        for name in ("goal_distance", "obstacle_radius"):
            low, high = _pair(name, getattr(self, name))
            is_right = _is_number(low) and _is_number(high) and 0.0 < low <= high
            _require(name, (low, high), is_right, "two increasing lengths above 0 m")
        low, high = self.obstacle_counts
        is_count = is_whole(low) and is_whole(high) and 0 <= low <= high <= _MOST
        _require("obstacles", self.obstacles, is_count, f"0 to {_MOST}, or two such numbers")
        _require_sequence("robot_scales", self.robot_scales, "numbers, one at least")
        _require("robot_scales", self.robot_scales, len(self.robot_scales) > 0, "one at least")
        for scale in self.robot_scales:
            _require_number("robot_scales", scale, above=0.0)
        self._check_kinds()

    def _check_kinds(self) -> None:
        """Raises a UsageError for a value of a wrong type."""
        if self.scatter is not None:
            _require_sequence("scatter", self.scatter, "patterns")
            are_strings = all(isinstance(each, str) for each in self.scatter)
            _require("scatter", self.scatter, are_strings, "a sequence of patterns")
        for name in ("flatten", "collision_ends", "neighbors_behind_walls"):
            value = getattr(self, name)
            _require(name, value, isinstance(value, (bool, np.bool_)), "true or false")
        for name in ("reward", "terminated"):
            value = getattr(self, name)
            _require(name, value, value is None or callable(value), "a function of a Transition")
        _require("params", self.params, isinstance(self.params, Mapping), "a dict by name")
        for name in ("observation", "privileged"):
            value = getattr(self, name)
            is_some = not isinstance(value, (list, tuple)) or len(value) > 0
            _require(name, value, is_some, "a part of observations, or one at least in a sequence")
        object.__setattr__(self, "rewards", _weights(self.rewards))
        object.__setattr__(self, "vary", ranges_of(self.vary))

    @property
    def obstacle_counts(self) -> Tuple[int, int]:
        """The least and the largest number of obstacles."""
        if isinstance(self.obstacles, (tuple, list)):
            return _pair("obstacles", self.obstacles)
        return (self.obstacles, self.obstacles)

    @property
    def worlds(self) -> Tuple[WorldName, ...]:
        """The worlds that episodes draw from."""
        return tuple(self.world) if isinstance(self.world, (tuple, list)) else (self.world,)

    @property
    def period(self) -> float:
        """Length of a step of the environment [s]."""
        return float(self.step_size * self.frame_skip)

    @property
    def longest_episode(self) -> int:
        """The number of steps after which an episode is truncated."""
        if self.time_limit == math.inf:
            return sys.maxsize
        return max(1, math.ceil(self.time_limit / self.period - 1e-9))

    @classmethod
    def of(cls, arguments: Mapping[str, Any]) -> "NavigationSettings":
        """Settings out of keyword arguments.

        Args:
            arguments: attributes of this class, by their names.

        Raises:
            UsageError: one is unknown (also a TypeError) or wrong.
        """
        known = [each.name for each in fields(cls)]
        for name in arguments:
            if name not in known:
                raise UnknownArgumentError(  # Python's words, which TorchRL expects
                    f"got an unexpected keyword argument '{name}'{suggestion(name, known)}; "
                    f"there are: {', '.join(known)}"
                )
        return cls(**arguments)


def is_whole(value: Any) -> bool:
    """True if a value is a whole number of Python or NumPy, and no boolean."""
    return isinstance(value, (int, np.integer)) and not isinstance(value, bool)


def require_seed(seed: Any) -> Optional[int]:
    """None, or a seed as Python's number, which Gymnasium expects.

    Raises:
        UsageError: it is neither None nor a number of 0 or more.
    """
    if not (seed is None or (is_whole(seed) and seed >= 0)):
        raise UsageError(f"expected seed to be None or a number of 0 or more, found {seed!r}")
    return None if seed is None else int(seed)


def _pair(name: str, value: Any) -> Tuple[Any, Any]:
    try:
        low, high = value
    except (TypeError, ValueError):
        raise UsageError(f"expected {name} as a pair (least, largest), found {value!r}") from None
    return low, high


def _weights(value: Any) -> RewardWeights:
    """The weights of rewards, from themselves or from a dict of some of them."""
    known = [each.name for each in fields(RewardWeights)]
    if isinstance(value, Mapping) and set(value) <= set(known):
        value = RewardWeights(**value)
    is_right = isinstance(value, RewardWeights)
    _require("rewards", value, is_right, f"RewardWeights, or a dict of: {', '.join(known)}")
    for name in known:
        _require_number(f"rewards.{name}", getattr(value, name))
    return RewardWeights(**{name: float(getattr(value, name)) for name in known})


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float, np.number)) and not isinstance(value, bool)


def _require_sequence(name: str, value: Any, content: str) -> None:
    is_right = isinstance(value, (Sequence, np.ndarray)) and not isinstance(value, (str, bytes))
    _require(name, value, is_right, f"a sequence of {content}")


def _require_number(
    name: str, value: Any, above: Optional[float] = None, minimum: float = -math.inf
) -> None:
    limit = f" above {above:g}" if above is not None else f" of {minimum:g} or more"
    if above is None and minimum == -math.inf:
        limit = ""
    is_right = _is_number(value) and abs(value) <= sys.float_info.max and value >= minimum
    _require(name, value, is_right and (above is None or value > above), f"a number{limit}")


def _require(name: str, value: Any, is_right: Any, expected: str) -> None:
    if not is_right:
        raise UsageError(f"expected {name} to be {expected}, found {value!r}")
