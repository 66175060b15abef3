"""A pedestrian: a model of a body, perhaps on two legs, that walks from goal to goal."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any, Sequence, Tuple

from flatland_plugins.crowd_config import PedestrianConfig
from flatland_server import (
    BodyConfig,
    Circle,
    Footprint,
    Model,
    ModelConfig,
    Point,
    Pose,
    wrap_angle,
)

_MASS = 80.0
"""Of each pedestrian [kg]."""

_LEG_RADIUS = 0.28
_LEG_OFFSET = 0.4
"""A leg's radius and its distance from the middle, as fractions of the pedestrian's radius."""

_LEGS = (("left_leg", 1.0), ("right_leg", -1.0))

_WALK_RATIO = 0.0064 * 60.0
"""A step's length by the steps per second [m s], about equal at all speeds.

N. Sekiya et al., "The invariant relationship between step length and step rate during free
walking", Journal of Human Movement Studies 30, 1996.
"""

_TURN_RATE = math.pi
"""Maximum rate of turn [rad/s]."""

_LEAST_SPEED = 0.1
"""Below this speed [m/s] they keep their heading."""


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
        shape=Circle((0.0, 0.0), _LEG_RADIUS * build.radius),
        density=0.0,
        collision=False,
        visible=True,
    )
    bodies = [BodyConfig("body", Pose(), "dynamic", build.color, 0.0, 0.0, (disc,))]
    for name, side in _LEGS if build.legs else ():
        pose = Pose(0.0, side * _LEG_OFFSET * build.radius)
        bodies.append(BodyConfig(name, pose, "kinematic", build.color, 0.0, 0.0, (leg,)))
    return ModelConfig(file, tuple(bodies), (), ())


class Pedestrian:
    """A pedestrian in the world."""

    def __init__(self, config: PedestrianConfig, model: Model) -> None:
        self.config = config
        self.model = model
        self._body = model.base.physics_body
        self._goal = 0
        self._stride = 0.25  # the part of a double step that is done; here the feet are abreast

    @property
    def position(self) -> Point:
        """Its position [m]."""
        return self._body.pose[:2]

    @property
    def velocity(self) -> Point:
        """Its velocity [m/s], including what pushes it."""
        return self._body.velocity[:2]

    def way(self, goal_radius: float, time_left: float) -> Point:
        """The desired direction: a vector towards its goal, of length 1 at full speed.

        When it is within `goal_radius` [m] of a goal, it turns to the next. With a single goal, it
        stays there, and slows down when it would arrive in less than `time_left` seconds.
        """
        goals, (x, y) = self.config.goals, self.position
        if math.dist((x, y), goals[self._goal]) <= goal_radius:
            self._goal = (self._goal + 1) % len(goals)
        dx, dy = goals[self._goal][0] - x, goals[self._goal][1] - y
        slow_down = self.config.build.speed * time_left if len(goals) == 1 else 1e-9
        distance = max(math.hypot(dx, dy), slow_down)
        return dx / distance, dy / distance

    def walk(self, vx: float, vy: float, dt: float) -> None:
        """Moves at a velocity [m/s] for the next `dt` seconds, turning to its direction."""
        x, y, yaw = self._body.pose
        turn = 0.0
        if math.hypot(vx, vy) > _LEAST_SPEED:
            turn = wrap_angle(math.atan2(vy, vx) - yaw)
            turn = max(-_TURN_RATE * dt, min(turn, _TURN_RATE * dt))
        self._body.velocity = (vx, vy, turn / dt)
        if self.config.build.legs:
            after = Pose(x + vx * dt, y + vy * dt, yaw + turn)
            forwards = vx * math.cos(after.yaw) + vy * math.sin(after.yaw)
            self._step(after, forwards, dt)

    def get_state(self) -> Tuple[int, float]:
        """Which goal it walks to, and the part of a double step that is done."""
        return self._goal, self._stride

    def set_state(self, state: Sequence[Any]) -> None:
        """Sets what `get_state` has returned."""
        self._goal, self._stride = state

    def _step(self, body: Pose, speed: float, dt: float) -> None:
        """Moves the legs to where they belong in `dt` seconds, when the body is there.

        Steps are sqrt(walk ratio * speed) long. A foot goes from half a step ahead to half a step
        behind while the body goes on by a step: it stands still on the floor.
        """
        step = math.sqrt(_WALK_RATIO * abs(speed))
        if step > 0.0:
            self._stride = (self._stride + speed * dt / (2.0 * step)) % 1.0
        ahead = step / 2.0 * (1.0 - 4.0 * abs(self._stride - 0.5))
        for name, side in _LEGS:
            leg = self.model.bodies[name].physics_body
            x, y, _ = leg.pose
            to_x, to_y = body.apply(side * ahead, side * _LEG_OFFSET * self.config.build.radius)
            leg.velocity = ((to_x - x) / dt, (to_y - y) / dt, 0.0)
