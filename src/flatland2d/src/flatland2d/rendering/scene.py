"""The parts of a picture of a world, from the ground up: grid, walls, sensors, bodies, names."""

import math
from itertools import cycle
from typing import Iterable, Tuple

import numpy as np

from flatland2d.rendering.view import View
from flatland_server.canvas import Canvas, Points, Rgba
from flatland_server.geometry import Point
from flatland_server.models import Circle, Layer, Model, ModelBody
from flatland_server.simulation import World

BACKGROUND: Rgba = (238 / 255, 238 / 255, 236 / 255, 1.0)
"""The background colour of flatland_viz."""

_GRID: Rgba = (223 / 255, 223 / 255, 222 / 255, 1.0)
_NAME: Rgba = (32 / 255, 32 / 255, 32 / 255, 1.0)
_TRAILS: Tuple[Rgba, ...] = ((0.2, 0.5, 0.8, 0.8), (0.9, 0.62, 0.0, 0.9))
_PALE = 0.8  # walls with more of each colour than this hardly differ from the background

_WALL_WIDTH = 0.05  # m
_OUTLINE_WIDTH = 0.01  # m
_JOINT_ARM = 0.05  # m
_LEAST_CELL = 14.0  # px
_TRAIL_WIDTH = 1.5  # px


def draw_ground(canvas: Canvas, view: View) -> None:
    """Draws a grid of metres, or of 2, 5, 10 ... metres where they would be too narrow."""
    cell = grid_cell(view.scale)
    left, right, bottom, top = view.extent
    columns = np.arange(math.ceil(left / cell), math.floor(right / cell) + 1) * cell
    rows = np.arange(math.ceil(bottom / cell), math.floor(top / cell) + 1) * cell
    half = 0.5 / view.scale  # a line in the middle of its pixels is sharp
    x = np.round(columns * view.scale) / view.scale + half
    y = np.round(rows * view.scale) / view.scale - half
    upright = np.column_stack([x, np.full_like(x, bottom), x, np.full_like(x, top)])
    level = np.column_stack([np.full_like(y, left), y, np.full_like(y, right), y])
    canvas.lines(np.vstack([upright, level]), _GRID)


def grid_cell(scale: float) -> float:
    """The width of the grid's cells [m] at a scale [px/m]: 1, 2, 5, 10, 20 ..."""
    least = max(1.0, _LEAST_CELL / scale)
    power = 10.0 ** math.floor(math.log10(least))
    return next(digit * power for digit in (1, 2, 5, 10) if digit * power >= least * (1 - 1e-9))


def draw_walls(canvas: Canvas, layers: Iterable[Layer], scale: float) -> None:
    """Draws the walls of layers, one layer after the other."""
    width = min(max(_WALL_WIDTH * scale, 1.0), 2.0)
    for layer in layers:
        canvas.lines(layer.segments, _visible(layer.config.color), width)


def draw_trails(canvas: Canvas, trails: Iterable[Points]) -> None:
    """Draws lines through past positions, in different colours."""
    for trail, color in zip(trails, cycle(_TRAILS)):
        canvas.path(trail, color, _TRAIL_WIDTH)


def draw_model(canvas: Canvas, model: Model, scale: float) -> None:
    """Draws a model as rviz shows it: footprints filled and outlined, sensors outlined only."""
    width = min(max(_OUTLINE_WIDTH * scale, 1.0), 2.0)
    for body in model.bodies.values():
        _draw_body(canvas, body, width)
    for joint in model.joints:
        body, anchor = model.bodies[joint.config.bodies[0]], joint.config.anchors[0]
        _draw_joint(canvas, body, anchor, joint.config.color, width)


def draw_name(canvas: Canvas, model: Model) -> None:
    """Writes a model's name beside it."""
    x, y, _ = model.pose
    aside = model.radius * math.sqrt(0.5)
    canvas.label((x + aside, y - aside), model.name, _NAME)


def bounds(world: World) -> Tuple[Point, Point]:
    """The lower left and the upper right corner of the contents of a world [m].

    Contents are the walls and the origins of the models; without walls, the models.
    """
    models = [each for each in world.models.values() if not each.is_away]
    places = [layer.segments.reshape(-1, 2) for layer in world.layers]
    margins = [0.0 if any(map(len, places)) else model.radius for model in models]
    for model, margin in zip(models, margins):
        x, y, _ = model.pose
        places.append(np.array([(x - margin, y - margin), (x + margin, y + margin)]))
    known = np.concatenate([*places, np.empty((0, 2))])
    if not len(known):
        return (0.0, 0.0), (0.0, 0.0)
    (left, bottom), (right, top) = known.min(axis=0).tolist(), known.max(axis=0).tolist()
    return (left, bottom), (right, top)


def _draw_body(canvas: Canvas, body: ModelBody, width: float) -> None:
    pose, color = body.pose, body.config.color
    red, green, blue, alpha = color
    dark = (0.4 * red, 0.4 * green, 0.4 * blue, max(alpha, 0.8))
    for footprint in body.config.footprints:
        shape, fill = footprint.shape, None if footprint.sensor else color
        if isinstance(shape, Circle):
            x, y = shape.center
            center = pose.apply(x, y)
            canvas.disc(center, shape.radius, fill, dark, width)
            heading = [(*center, *pose.apply(x + shape.radius, y))]
            canvas.lines(np.array(heading), dark, width)
        else:
            canvas.area([pose.apply(*corner) for corner in shape.vertices], fill, dark, width)


def _draw_joint(canvas: Canvas, body: ModelBody, anchor: Point, color: Rgba, width: float) -> None:
    """Draws a cross at the anchor on the joint's first body."""
    x, y = anchor
    ends = [(x - _JOINT_ARM, y), (x + _JOINT_ARM, y), (x, y - _JOINT_ARM), (x, y + _JOINT_ARM)]
    cross = np.array([body.pose.apply(*end) for end in ends]).reshape(-1, 4)
    canvas.lines(cross, color, width)


def _visible(color: Rgba) -> Rgba:
    """A wall's colour, darkened if it is as pale as the background; white is the default."""
    red, green, blue, alpha = color
    if min(red, green, blue) < _PALE:
        return color
    return 0.6 * red, 0.6 * green, 0.6 * blue, alpha
