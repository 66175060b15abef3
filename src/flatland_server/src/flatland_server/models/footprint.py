"""Footprints: the shapes of a body, with their material and their collision layers."""

import math
from dataclasses import dataclass
from typing import Any, Dict, Iterable, List, Optional, Sequence, Tuple, Union

from flatland_server import _core
from flatland_server.arguments import shown
from flatland_server.config.plain_nodes import to_node
from flatland_server.config.yaml_reader import YamlReader
from flatland_server.exceptions import UsageError
from flatland_server.geometry import Point
from flatland_server.models.collision_filter_registry import ALL, CollisionFilterRegistry

_CIRCLE_SIDES = 36


@dataclass(frozen=True)
class Circle:
    """A disc.

    Attributes:
        center: in the body's frame [m].
        radius: [m].
    """

    center: Point
    radius: float

    def outline(self) -> Sequence[Point]:
        """The corners of a regular polygon that approximates it [m]."""
        x, y = self.center
        angles = [math.tau * i / _CIRCLE_SIDES for i in range(_CIRCLE_SIDES)]
        return [(x + self.radius * math.cos(a), y + self.radius * math.sin(a)) for a in angles]


@dataclass(frozen=True)
class Polygon:
    """A convex polygon.

    Attributes:
        vertices: 3 to 8, in the body's frame and in either order [m].
    """

    vertices: Tuple[Point, ...]

    def outline(self) -> Sequence[Point]:
        """Its vertices [m]."""
        return self.vertices


@dataclass(frozen=True)
class Footprint:
    """An entry of a body's `footprints`.

    Attributes:
        shape: in the body's frame.
        density: [kg/m^2].
        friction: Box2D's coefficient of friction.
        restitution: Box2D's coefficient of restitution.
        sensor: whether it reports contacts without responding to them.
        collision: whether it collides at all.
        layers: names of the collision layers that it is on.
        layer_bits: the bits of these layers.
        visible: whether lasers see it. Always true in files; for bodies that plugins create.
    """

    shape: Union[Circle, Polygon]
    density: float
    friction: float
    restitution: float
    sensor: bool
    collision: bool
    layers: Tuple[str, ...]
    layer_bits: int
    visible: bool = True

    @classmethod
    def read(
        cls, reader: YamlReader, registry: CollisionFilterRegistry, checker: _core.Body
    ) -> "Footprint":
        """Reads an entry.

        Args:
            reader: the entry.
            registry: the layers that footprints may name.
            checker: a body in a world of its own, with the previous footprints of the read body.

        Raises:
            YamlError: something in it is wrong, or Box2D cannot take the shape.
        """
        shape: Union[Circle, Polygon]
        if reader.get_choice("type", ["circle", "polygon"]) == "circle":
            shape = Circle(
                reader.get_point("center", (0.0, 0.0)), reader.get_float("radius", above=0.0)
            )
        else:
            vertices = tuple(reader.get_points("points", 3, 8))
            if not _is_convex(vertices):
                vertices = _hull_of(vertices, reader)
            shape = Polygon(vertices)
        layers = reader.get_strings("layers", (ALL,))
        layer_bits = 0
        try:
            layer_bits = registry.bits(layers)
        except ValueError as error:
            reader.problem(str(error), "layers")
        footprint = cls(
            shape,
            density=reader.get_float("density", minimum=0.0),
            friction=reader.get_float("friction", 0.0, minimum=0.0),
            restitution=reader.get_float("restitution", 0.0, minimum=0.0),
            sensor=reader.get_bool("sensor", False),
            collision=reader.get_bool("collision", True),
            layers=layers,
            layer_bits=layer_bits,
        )
        reader.finish()
        try:
            footprint.attach(checker)
        except ValueError as error:
            raise reader.error(str(error)) from None
        return footprint

    def changes(
        self,
        shape: Optional[Union[Circle, Polygon]],
        layers: Optional[Sequence[str]],
        registry: CollisionFilterRegistry,
        model: str,
        path: str,
    ) -> Dict[str, Any]:
        """Checks a new shape and new layers as if they were in a file.

        Args:
            shape: None leaves it as it is.
            layers: None leaves them as they are.
            registry: the layers that footprints may name.
            model: name that stands for the file in errors.
            path: place that stands for the place in the file in errors.

        Returns:
            The attributes that change, for `dataclasses.replace`.

        Raises:
            FlatlandError: something in them is wrong.
        """
        shape_given, shape = shape is not None, shape or self.shape
        if isinstance(shape, Circle):
            keys = {"type": "circle", "center": shape.center, "radius": shape.radius}
        elif isinstance(shape, Polygon):
            keys = {"type": "polygon", "points": shape.vertices}
        else:
            raise UsageError(f"expected a Circle or a Polygon, found {shown(shape)}")
        keys.update(density=self.density, layers=self.layers if layers is None else layers)
        reader = YamlReader(to_node(keys, model, path), path)
        read = self.read(reader, registry, _core.World().add_body("static", (0.0, 0.0, 0.0)))
        changes: Dict[str, Any] = {"shape": read.shape} if shape_given else {}
        if layers is not None:
            changes.update(layers=read.layers, layer_bits=read.layer_bits)
        return changes

    def reshape(self, fixture: _core.Fixture) -> None:
        """Gives a fixture this shape and these layers.

        Args:
            fixture: fixture to change; it keeps its material.

        Raises:
            ValueError: the body cannot have the shape.
        """
        if isinstance(self.shape, Circle):
            fixture.set_circle(self.shape.center, self.shape.radius, layers=self.layer_bits)
        else:
            fixture.set_polygon(self.shape.vertices, layers=self.layer_bits)

    def attach(self, body: _core.Body) -> None:
        """Adds this shape, with its material, to a body.

        Args:
            body: body that gets the shape.

        Raises:
            ValueError: Box2D cannot represent the shape.
        """
        material: Dict[str, Any] = {
            "density": self.density,
            "friction": self.friction,
            "restitution": self.restitution,
            "sensor": self.sensor,
            "collides": self.collision,
            "visible": self.visible,
            "layers": self.layer_bits,
        }
        if isinstance(self.shape, Circle):
            body.add_circle(self.shape.center, self.shape.radius, **material)
        else:
            body.add_polygon(self.shape.vertices, **material)


def _hull_of(vertices: Tuple[Point, ...], reader: YamlReader) -> Tuple[Point, ...]:
    """The convex hull of a polygon, which Box2D would make of it, with a warning."""
    hull = convex_hull(vertices)
    if len(hull) < 3:
        return vertices  # Box2D refuses them
    lost = [f"[{x:g}, {y:g}]" for x, y in vertices if (x, y) not in hull]
    change = f"without {', '.join(lost)}" if lost else "in another order"
    areas = f"{_area(vertices):.4g} m2 before, {_area(hull):.4g} m2 now"
    message = f"expected a convex polygon; its hull is taken, {change}: {areas}"
    reader.warn(message, "points")
    return hull


def _area(vertices: Sequence[Point]) -> float:
    """The area by the shoelace formula [m^2]; beyond a crossing, it counts negative."""
    pairs = zip(vertices, (*vertices[1:], vertices[0]))
    return abs(sum(ax * by - bx * ay for (ax, ay), (bx, by) in pairs)) / 2.0


def convex_hull(points: Sequence[Point]) -> Tuple[Point, ...]:
    """The corners of the convex hull, counter-clockwise, by Andrew's monotone chain."""

    def half(ordered: Iterable[Point]) -> List[Point]:
        chain: List[Point] = []
        for x, y in ordered:
            while len(chain) > 1:
                (ax, ay), (bx, by) = chain[-2:]
                if (bx - ax) * (y - ay) - (by - ay) * (x - ax) > 0.0:
                    break
                chain.pop()
            chain.append((x, y))
        return chain[:-1]

    ordered = sorted(set(points))
    return (*half(ordered), *half(reversed(ordered)))


def _is_convex(vertices: Tuple[Point, ...]) -> bool:
    """True if a polygon is convex: it turns in one direction only, by one revolution in total."""
    angles = []  # between consecutive sides
    for (ax, ay), (bx, by), (cx, cy) in zip(
        vertices, vertices[1:] + vertices[:1], vertices[2:] + vertices[:2]
    ):
        ux, uy, vx, vy = bx - ax, by - ay, cx - bx, cy - by
        angles.append(math.atan2(ux * vy - uy * vx, ux * vx + uy * vy))
    # At a vertex within a straight side the angle is zero up to rounding.
    one_direction = all(a > -1e-6 for a in angles) or all(a < 1e-6 for a in angles)
    return one_direction and abs(sum(angles)) < 3 * math.pi
