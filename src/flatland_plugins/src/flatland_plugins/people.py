"""The people of a crowd: their models, and as arrays their ways, turns and legs.

Arrays are those of one world or of many at once. They hold n worlds with p people each: goals
(n, p), points (n, p, 2), poses (n, p, 3).
"""

import math
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple, Optional, Sequence, Tuple

import numpy as np

from flatland_plugins.crowd_config import Build, PedestrianConfig
from flatland_plugins.social_force import directions
from flatland_server import (
    BodyConfig,
    Circle,
    FloatArray,
    Footprint,
    IntArray,
    Model,
    ModelBody,
    ModelConfig,
    Pose,
    cos_sin,
    headings,
)

_MASS = 80.0
"""Of each pedestrian [kg]."""

LEG_RADIUS = 0.28
_LEG_OFFSET = 0.4
"""A leg's radius and its distance from the middle, as fractions of the pedestrian's radius."""

LEGS = (("left_leg", 1.0), ("right_leg", -1.0))
"""The names of their bodies, and on which side they are: 1 is the left."""

_TURN_RATE = math.pi
"""Maximum rate of turn [rad/s]."""

LEAST_SPEED = 0.1
"""Speed [m/s] below which people keep their heading."""

_FEET_ABREAST = 0.25


def model_of(
    config: PedestrianConfig, file: Path, layers: Tuple[str, ...], layer_bits: int
) -> ModelConfig:
    """The model of a pedestrian: a disc; if it has legs, lasers see two smaller ones instead."""
    build = config.build
    disc = Footprint(
        Circle((0.0, 0.0), build.radius),
        density=_MASS / (math.pi * build.radius**2),
        friction=0.0,
        restitution=0.0,
        sensor=False,
        collision=True,
        layers=layers,
        layer_bits=layer_bits,
        visible=not build.legs,
    )
    leg = replace(
        disc,
        shape=Circle((0.0, 0.0), LEG_RADIUS * build.radius),
        density=0.0,
        collision=False,
        visible=True,
    )
    bodies = [BodyConfig("body", Pose(), "dynamic", build.color, 0.0, 0.0, (disc,))]
    for name, side in LEGS if build.legs else ():
        pose = Pose(0.0, side * leg_offset(build))
        bodies.append(BodyConfig(name, pose, "kinematic", build.color, 0.0, 0.0, (leg,)))
    return ModelConfig(file, tuple(bodies), (), ())


class Person(NamedTuple):
    """A pedestrian in the world.

    Attributes:
        config: its configuration.
        model: its model.
        body: the body that walks.
        legs: the left one and the right one, if it has legs.
        circle: a body that goes along with it.
    """

    config: PedestrianConfig
    model: Model
    body: ModelBody
    legs: Sequence[ModelBody]
    circle: Optional[ModelBody] = None

    @classmethod
    def of(cls, config: PedestrianConfig, model: Model) -> "Person":
        """The pedestrian of a model that `model_of` has made."""
        legs = [model.bodies[name] for name, _ in LEGS if config.build.legs]
        return cls(config, model, model.base, legs)


class Progress(NamedTuple):
    """The progress of people on their ways.

    Attributes:
        goals: index of each person's present goal, (n, p).
        strides: completed fraction of a double step, (n, p).
    """

    goals: IntArray
    strides: FloatArray

    @classmethod
    def of(cls, worlds: int, people: int) -> "Progress":
        """The progress at the start: on the way to the first goal, with both feet abreast."""
        shape = (worlds, people)
        return cls(np.zeros(shape, np.int64), np.full(shape, _FEET_ABREAST))


class People:
    """The constant properties of p people.

    Args:
        configs: of the people.

    Attributes:
        radii: [m], (p,).
        speeds: desired ones [m/s], (p,).
        walkers: indices of those with legs, (q,).
    """

    def __init__(self, configs: Sequence[PedestrianConfig]) -> None:
        self.radii = np.array([each.build.radius for each in configs])
        self.speeds = np.array([each.build.speed for each in configs])
        self.walkers = np.array([i for i, c in enumerate(configs) if c.build.legs], np.int64)
        self._leg_offsets = np.array([leg_offset(each.build) for each in configs])
        self._walk_ratios = np.array([each.build.walk_ratio for each in configs])
        self._goal_counts = np.array([len(each.goals) for each in configs], np.int64)
        self._goals = np.zeros((len(configs), self._goal_counts.max(initial=0), 2))
        for index, each in enumerate(configs):
            self._goals[index, : len(each.goals)] = each.goals
        self._index = np.arange(len(configs))

    def __len__(self) -> int:
        return len(self.radii)

    def ways(
        self, goals: IntArray, points: FloatArray, goal_radius: float, time_left: float
    ) -> Tuple[IntArray, FloatArray]:
        """The present goals, and the desired directions: of length 1 at full speed.

        A person within `goal_radius` [m] of a goal turns to the next. With a single goal, it stays
        there, and slows down when it would arrive in less than `time_left` seconds.
        """
        _, left = directions(self._goals[self._index, goals] - points)
        goals = np.where(left <= goal_radius, (goals + 1) % self._goal_counts, goals)
        vectors = self._goals[self._index, goals] - points
        _, left = directions(vectors)
        slow_down = np.where(self._goal_counts == 1, self.speeds * time_left, 1e-9)
        return goals, vectors / np.maximum(left, slow_down)[..., np.newaxis]

    def turns(self, yaws: FloatArray, velocities: FloatArray, dt: float) -> FloatArray:
        """The turns in `dt` seconds towards the direction of the velocities [rad]."""
        turn = headings(velocities) - yaws
        turn -= math.tau * np.rint(turn / math.tau)
        _, speeds = directions(velocities)
        turn = np.minimum(np.maximum(turn, -_TURN_RATE * dt), _TURN_RATE * dt)
        return np.where(speeds > LEAST_SPEED, turn, 0.0)

    def step(
        self, strides: FloatArray, poses: FloatArray, motions: FloatArray, dt: float
    ) -> Tuple[FloatArray, FloatArray]:
        """The strides and the positions of legs after `dt` seconds.

        Steps are sqrt(walk ratio * speed) long. A foot goes from half a step ahead to half a step
        behind while the body goes on by a step: it stands still on the floor.

        Args:
            strides: now, (n, p).
            poses: of the bodies now, (n, p, 3).
            motions: their velocities from now on [m/s, m/s, rad/s], (n, p, 3).
            dt: [s].

        Returns:
            Strides (n, p), and positions of left and right legs [m], (n, q, 2, 2).
        """
        after = poses + motions * dt
        cos, sin = cos_sin(after[..., 2])
        speeds = motions[..., 0] * cos + motions[..., 1] * sin
        steps = np.sqrt(self._walk_ratios * np.abs(speeds))
        done = speeds * dt / (2.0 * np.where(steps > 0.0, steps, 1.0))
        strides = (strides + np.where(steps > 0.0, done, 0.0)) % 1.0
        ahead = steps / 2.0 * (1.0 - 4.0 * np.abs(strides - 0.5))
        places = []
        for _, side in LEGS:
            x, y = side * ahead, side * self._leg_offsets
            place = after[..., 0] + cos * x - sin * y, after[..., 1] + sin * x + cos * y
            places.append(np.stack(place, axis=-1))
        return strides, np.stack(places, axis=-2)[:, self.walkers]


def leg_offset(build: Build) -> float:
    """The distance of a leg from the middle [m]."""
    return _LEG_OFFSET * build.radius if build.leg_offset is None else build.leg_offset
