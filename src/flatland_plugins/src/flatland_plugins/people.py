"""The people of a crowd: their models, and how they join a crowd of the core, which moves them."""

import math
from dataclasses import astuple, replace
from pathlib import Path
from typing import NamedTuple, Optional, Sequence, Tuple

from flatland_plugins.crowd_config import Build, PedestrianConfig
from flatland_server import (
    BodyConfig,
    Circle,
    Crowd,
    Footprint,
    Model,
    ModelBody,
    ModelConfig,
    Pose,
)

_MASS = 80.0
"""Of each pedestrian [kg]."""

LEG_RADIUS = 0.28
_LEG_OFFSET = 0.4
"""A leg's radius and its distance from the middle, as fractions of the pedestrian's radius."""

LEGS = (("left_leg", 1.0), ("right_leg", -1.0))
"""The names of their bodies, and on which side they are: 1 is the left."""


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

    def join(
        self, crowd: Crowd, leg_radii: Tuple[float, float] = (0.0, 0.0), group: int = -1
    ) -> None:
        """Lets it walk as one of a crowd.

        Args:
            crowd: the crowd in the core.
            leg_radii: of a leg on the floor, and in the middle of its swing [m].
            group: the number of its group; -1: none.
        """
        build = self.config.build
        crowd.add_person(
            self.body.physics_body,
            goals=self.config.goals,
            radius=build.radius,
            speed=build.speed,
            legs=[leg.physics_body for leg in self.legs],
            circle=None if self.circle is None else self.circle.physics_body,
            leg_offset=leg_offset(build),
            walk_ratio=build.walk_ratio,
            leg_radii=leg_radii,
            attention=astuple(self.config.attention),
            group=group,
            area=self.config.area,
            stands=self.config.stands,
            recording=self.config.walks,
        )

    @classmethod
    def of(cls, config: PedestrianConfig, model: Model) -> "Person":
        """The pedestrian of a model that `model_of` has made."""
        legs = [model.bodies[name] for name, _ in LEGS if config.build.legs]
        return cls(config, model, model.base, legs)


def leg_offset(build: Build) -> float:
    """The distance of a leg from the middle [m]."""
    return _LEG_OFFSET * build.radius if build.leg_offset is None else build.leg_offset
