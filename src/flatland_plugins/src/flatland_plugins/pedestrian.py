"""A pedestrian: a model of a body, perhaps on two legs."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Tuple

from flatland_plugins.crowd_config import PedestrianConfig
from flatland_server import BodyConfig, Circle, Footprint, Model, ModelConfig, Pose

_MASS = 80.0
"""Of each pedestrian [kg]."""

_LEG_RADIUS = 0.28
LEG_OFFSET = 0.4
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
        shape=Circle((0.0, 0.0), _LEG_RADIUS * build.radius),
        density=0.0,
        collision=False,
        visible=True,
    )
    bodies = [BodyConfig("body", Pose(), "dynamic", build.color, 0.0, 0.0, (disc,))]
    for name, side in LEGS if build.legs else ():
        pose = Pose(0.0, side * LEG_OFFSET * build.radius)
        bodies.append(BodyConfig(name, pose, "kinematic", build.color, 0.0, 0.0, (leg,)))
    return ModelConfig(file, tuple(bodies), (), ())


class Pedestrian:
    """A pedestrian in the world.

    Attributes:
        config: its entry in the world file.
        model: its model.
        legs: the names of the bodies of its legs, if it has some.
    """

    def __init__(self, config: PedestrianConfig, model: Model) -> None:
        self.config = config
        self.model = model
        self.legs = [name for name, _ in LEGS] if config.build.legs else []
