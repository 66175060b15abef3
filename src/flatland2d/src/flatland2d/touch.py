"""Pairs of touching bodies, as plain values."""

from dataclasses import dataclass
from typing import List, Optional, Tuple

from flatland_server.geometry import Point
from flatland_server.models import Entity
from flatland_server.simulation import World


@dataclass(frozen=True)
class Touch:
    """Two bodies that touch.

    Attributes:
        model_a: the name of a model, or of a layer of walls.
        body_a: its body; for a layer, the layer's name again.
        model_b: the other model or layer.
        body_b: its body.
        points: up to two points where they touch, in the world [m]; none with a sensor.
        normal: unit vector from a to b in the world's frame; zero with a sensor.
    """

    model_a: str
    body_a: str
    model_b: str
    body_b: str
    points: Tuple[Point, ...]
    normal: Point

    def of(self, model: str) -> bool:
        """True if one of the two bodies belongs to a model or layer.

        Args:
            model: name of the model or layer.
        """
        return model in (self.model_a, self.model_b)


def touches(world: World) -> List[Touch]:
    """The pairs of bodies that touched in the last step, in a fixed order.

    Bodies that plugins have created by themselves, outside of models, are left out.
    """
    found = []
    for fixture_a, fixture_b, points, normal in world.physics.touches:
        a: Optional[Entity] = world.entities.find(fixture_a.body.id)
        b: Optional[Entity] = world.entities.find(fixture_b.body.id)
        if a is not None and b is not None:
            bodies = a.body_name(fixture_a), b.body_name(fixture_b)
            found.append(Touch(a.name, bodies[0], b.name, bodies[1], tuple(points), normal))
    return found
