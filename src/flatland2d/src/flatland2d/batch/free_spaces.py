"""The free space for the initial poses of a batch's robots."""

from typing import Any, Dict, Sequence

import numpy as np

from flatland2d.free_space import DistanceGrid, FreeSpace, discs_of
from flatland2d.robot import Robot
from flatland_server.arguments import shown
from flatland_server.arrays import FloatArray
from flatland_server.config import LARGEST
from flatland_server.exceptions import UsageError
from flatland_server.models import Model
from flatland_server.simulation import World


def free_space_of(
    world: World, robots: Sequence[Robot], clearance: Any, known: Dict[float, FreeSpace]
) -> FreeSpace:
    """The free space with a distance [m] from all walls and the circles around other models.

    Args:
        world: the initial world of all environments.
        robots: their models; the other models are obstacles.
        clearance: the distance [m].
        known: the free spaces that were computed before, by their clearances.

    Raises:
        UsageError: the clearance is not usable, or leaves no place.
    """
    is_number = isinstance(clearance, (int, float, np.number))
    if not (is_number and 0.0 < clearance <= LARGEST):
        raise UsageError(f"expected a clearance above zero, found {shown(clearance)}")
    if clearance not in known:
        models = [robot.model for robot in robots]
        others = [each for each in world.models.values() if each not in models]
        grid = DistanceGrid(
            _walls(world, models),
            models[0].pose[:2],
            clearance,
            discs=discs_of((each.pose, each.radius) for each in others),
            resolution=min(max(clearance / 6.0, 0.02), 0.1),
        )
        space = grid.free_space(clearance)
        if space.area == 0.0:
            raise UsageError(f"no place has a clearance of {clearance:g} m")
        known[clearance] = space
    return known[clearance]


def _walls(world: World, models: Sequence[Model]) -> FloatArray:
    """The walls that models collide with: shape (n, 4)."""
    bits = 0
    for model in models:
        for body in model.physics_bodies:
            for fixture in body.fixtures:
                bits |= fixture.layers
    config = world.config
    walls = [config.walls_of(layer) for layer in config.layers if layer.bits & bits]
    return np.concatenate([np.empty((0, 4)), *walls])
