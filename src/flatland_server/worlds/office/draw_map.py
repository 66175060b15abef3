#!/usr/bin/env python3
"""Draws office.png, the floor plan of the default world: 65 x 25 m at 0.05 m a pixel.

Everything is a part at a pose: a part is made of other parts, down to blocks and ovals. Lengths are
metres, angles degrees. The outermost frame is the world's: (0, 0) is where the robot starts, in the
lobby where the corridors meet. Run it again after a change: ./draw_map.py
"""

from __future__ import annotations

import math
import random
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Callable, Tuple

from PIL import Image

RESOLUTION = 0.05  # metres a pixel, as in office.yaml
ORIGIN = (-30.0, -12.5)  # bottom left corner of the image in the world, as in office.yaml
SIZE = (1300, 500)  # pixels
OCCUPIED, FREE = 0, 255

Part = Tuple[Any, ...]  # (what, u, v, angle), and for blocks and ovals: width, depth, corner radius

# fmt: off
PARTS: dict[str, list[Part]] = {
    # Furniture. Whoever uses it is on the side of negative v.
    "chair": [("oval", 0, 0, 0, 0.5, 0.5)],
    "desk": [("block", 0, 0, 0, 1.6, 0.8), ("chair", 0, -0.55, 0)],
    "shelf": [("block", 0, 0, 0, 1.6, 0.4)],
    "pillar": [("block", 0, 0, 0, 0.4, 0.4)],
    "plant": [("leaf", 0, 0, 72 * k) for k in range(5)],
    "leaf": [("oval", 0.18, 0, 0, 0.36, 0.22)],
    "sofa": [
        ("block", 0, 0.05, 0, 1.5, 0.6, 0.08), ("block", 0, 0.3, 0, 1.8, 0.25, 0.12),
        *[("block", arm, 0, 0, 0.24, 0.85, 0.12) for arm in (-0.78, 0.78)],
    ],
    "table": [
        ("oval", 0, 0, 0, 1.1, 1.1),
        *[("chair", u, v, 0) for u, v in ((0.7, 0.3), (-0.55, 0.5), (-0.05, -0.75))],
    ],
    "island": [("desk", u, v, a) for u in (-0.8, 0.8) for v, a in ((-0.4, 0), (0.4, 180))],
    "star": [("wing", 0, 0, 120 * k) for k in range(3)],
    "wing": [("block", 0.85, 0, 0, 1.7, 0.7, 0.15), ("chair", 0.5, 0.87, 0)],
    "bench": [("block", 0, 0, 0, 2.4, 0.9), ("chair", -0.5, -0.6, 0), ("chair", 0.6, -0.6, 0)],
    "reception": [("counter", 0, 0, 7 + 15 * k) for k in range(5)],
    "counter": [("block", 1.5, 0, 0, 0.5, 0.5, 0.1)],
    "cubicle": [
        ("block", 0.6, 0.9, 0, 1.2, 0.1), ("block", 0.05, 0.75, 0, 0.1, 0.3),
        ("block", 1.05, 0.4, 0, 0.2, 0.5), ("block", 0.8, 0.4, 0, 0.4, 0.35, 0.1),
    ],
    "flight": [("block", 0, 0.3 * k, 0, 1.2, 0.05) for k in range(12)],

    # What is in rooms. The frame stands at the left end of the wall with the door and looks in,
    # along positive v. The door is 0.35 to 1.25 m from that end.
    "pair": [
        ("desk", 2.4, 3.5, -90), ("desk", 3.22, 3.5, 90), ("shelf", 4.85, 1.2, 90),
        ("block", 0.25, 3.0, 0, 0.4, 2.8),
    ],
    "angled": [
        ("desk", 3.5, 3.0, 168), ("chair", 3.2, 1.7, 0), ("block", 0.25, 3.4, 0, 0.4, 2.2),
        ("shelf", 4.2, 0.25, 0),
    ],
    "row": [
        ("desk", 1.1, 4.15, 0), ("desk", 3.1, 4.15, 0), ("block", 2.1, 4.3, 0, 0.3, 0.5),
        ("shelf", 4.85, 1.4, 90), ("shelf", 2.8, 0.25, 0),
    ],
    "corner": [
        ("desk", 3.8, 1.3, -90), ("desk", 3.8, 3.5, -90), ("desk", 1.2, 3.8, 15),
        ("block", 2.4, 0.25, 0, 1.2, 0.4),
    ],
    "solo": [
        ("desk", 2.4, 3.2, 170), ("shelf", 4.05, 1.3, 90), ("plant", 0.5, 4.1, 0),
    ],
    "store": [("block", 2.2 + 1.3 * k, 3.2, 0, 0.5, 2.5) for k in range(3)],
    "team": [("island", 4.0, 2.4, 0), ("sofa", 1.2, 4.0, 0), ("block", 3.6, 4.35, 0, 2.4, 0.4)],
    "manager": [
        ("table", 4.5, 1.4, 0), ("block", 4.2, 3.9, 165, 2.0, 0.9, 0.3), ("chair", 5.0, 4.5, 0),
        ("sofa", 1.5, 4.95, 0), ("plant", 0.5, 2.5, 0),
    ],
    "meeting": [
        ("oval", 4.3, 2.4, 0, 4.2, 1.5), ("block", 4.3, 4.35, 0, 2.4, 0.4), ("plant", 7.4, 0.6, 0),
        *[("chair", u, v, 0) for u in (3.0, 3.9, 4.7, 5.6) for v in (1.5, 3.3)],
        ("chair", 2.1, 2.4, 0), ("block", 7.85, 2.3, 0, 0.1, 2.0),
    ],
    "archive": [("block", 1.5 + 1.35 * k, 3.1, 0, 0.5, 2.6) for k in range(5)],
    "training": [
        *[("block", u, v, 0, 1.8, 0.6) for u in (2.0, 4.7) for v in (1.8, 3.4, 5.0, 6.6)],
        *[("chair", u, v, 0) for u in (1.7, 4.4) for v in (1.4, 3.0, 4.6, 6.2)],
        ("block", 4.4, 7.8, -20, 0.7, 0.5, 0.1), ("block", 2.9, 8.75, 0, 3.0, 0.1),
    ],
    "booth": [("sofa", 1.4, 1.9, 0), ("block", 2.3, 0.5, 0, 0.5, 0.5)],
    "copy room": [
        ("block", 3.2, 0.3, 0, 2.6, 0.5),
        *[("block", u, 1.95, 0, 1.0, 0.7, 0.15) for u in (1.2, 2.5, 3.8)],
    ],
    "toilets": [
        *[("cubicle", 1.4, 1.5 + 0.95 * k, 0) for k in range(4)],
        *[("block", 0.2, 2.0 + 0.8 * k, 0, 0.3, 0.5) for k in range(4)],
    ],
    "stairs": [  # and a lift behind them, its door open
        ("flight", 3.45, 1.9, 0), ("flight", 4.75, 1.9, 0), ("block", 2.8, 3.55, 0, 0.1, 3.4),
        ("block", 4.1, 3.55, 0, 0.1, 3.4), ("block", 0.3, 3.6, 0, 0.6, 0.2),
        ("block", 2.0, 3.6, 0, 1.0, 0.2), ("block", 2.4, 4.5, 0, 0.2, 2.0),
    ],
    "workshop": [
        ("bench", 3.0, 3.2, 14), ("bench", 3.2, 6.4, 0), ("bench", 2.6, 9.7, 0),
        ("oval", 6.3, 3.6, 0, 1.4, 1.4), ("block", 6.4, 6.6, 0, 1.8, 1.2, 0.2),
        ("block", 6.6, 10.2, 0, 3.0, 0.8), ("shelf", 8.75, 4.6, 90), ("shelf", 0.25, 4.6, 90),
    ],
    "canteen": [
        ("block", 4.2, 10.35, 0, 7.0, 0.6), ("block", 4.4, 8.6, 0, 3.0, 0.9, 0.15),
        ("block", 8.1, 10.2, 0, 0.7, 0.8), ("table", 2.0, 3.0, 0), ("table", 6.6, 2.2, 30),
        ("table", 2.0, 7.0, 50), ("table", 6.9, 5.9, 10), ("plant", 8.0, 8.6, 0),
    ],
    "lounge": [
        ("sofa", 3.0, 5.45, 0), ("sofa", 5.45, 3.4, -90), ("oval", 3.4, 3.8, 0, 1.0, 1.0),
        ("block", 2.8, 1.9, 0, 2.4, 1.3), ("plant", 5.4, 5.4, 0),
    ],
    "open plan": [  # in the world's frame, as is the lobby
        ("island", -21.3, -4.1, 0), ("island", -16.6, -4.1, 0), ("star", -12.0, -4.2, 10),
        ("island", -21.3, -9.4, 0), ("island", -16.4, -9.5, 0), ("island", -11.6, -9.2, 90),
        ("sofa", -18.4, -6.4, 0), ("oval", -18.4, -7.3, 0, 0.8, 0.8),
        *[("pillar", x, y, 0) for x in (-20.2, -16.4, -12.6) for y in (-1.4, -6.6)],
        *[("block", x, -1.4, 0, 1.8, 0.35, 0.1) for x in (-22.4, -18.3, -14.5, -10.4)],
        ("plant", -23.5, -11.3, 0),
    ],
    "lobby": [  # and the corridors
        ("reception", -3.4, 5.8, -90), ("chair", -2.8, 5.2, 0), ("oval", 0, 2.5, 0, 1.2, 1.2),
        ("sofa", 2.4, 5.35, 0), ("pillar", -3.15, 1.45, 0), ("pillar", 3.15, 1.45, 0),
        ("block", -2.25, 5.8, 0, 2.4, 0.1), ("block", 2.25, 5.8, 0, 2.4, 0.1),
        *[("block", x, 1.0, 0, 1.2, 0.3) for x in (-21.8, -11.6, 8.0)],
        *[("block", x, -1.0, 0, 1.2, 0.3) for x in (-27.0, 13.0, 30.5)],
        ("shelf", 0.85, -9.5, 90), ("shelf", -12.0, 7.05, 0), ("plant", 0.6, 11.3, 0),
        ("plant", 33.9, -0.6, 0),
    ],
}

# (x, y, angle, mirrored, width, depth, angle of the open door leaf or 0, what)
ROOMS: list[tuple[Any, ...]] = [
    (-29.5, 1.2, 0, False, 5.1, 4.6, 90, "pair"),
    (-19.3, 1.2, 0, True, 5.1, 4.6, 0, "angled"),
    (-19.3, 1.2, 0, False, 5.1, 4.6, 90, "row"),
    (-9.1, 1.2, 0, True, 5.1, 4.6, 75, "pair"),
    (-9.1, 1.2, 0, False, 5.7, 4.6, 0, "angled"),
    (-24.0, 5.8, 90, False, 6.1, 5.5, 0, "manager"),
    (-18.8, 7.3, 0, True, 5.2, 4.6, 90, "row"),
    (-18.8, 7.3, 0, False, 5.2, 4.6, 0, "pair"),
    (-8.4, 7.3, 0, True, 5.2, 4.6, 90, "row"),
    (-8.4, 7.3, 0, False, 7.3, 4.6, 90, "archive"),
    (3.4, 1.2, 0, False, 8.0, 4.6, 90, "meeting"),
    (15.7, 1.2, 0, True, 4.3, 4.6, 0, "corner"),
    (15.7, 1.2, 0, False, 4.3, 4.6, 90, "solo"),
    (1.1, 7.3, 0, False, 6.3, 4.6, 110, "team"),
    (13.7, 7.3, 0, True, 6.3, 4.6, 0, "team"),
    (20.0, 7.3, 0, True, 6.3, 4.6, 80, "team"),
    (20.0, 1.2, 0, False, 8.5, 10.7, 0, "canteen"),
    (28.5, 1.2, 0, False, 6.0, 6.0, 0, "lounge"),
    (-24.0, -1.2, 180, False, 5.5, 5.3, 90, "angled"),
    (-24.0, -6.5, 90, True, 5.4, 5.5, 0, "angled"),
    (-9.0, -1.2, -90, False, 2.7, 2.4, 100, "booth"),
    (-9.0, -3.9, -90, False, 2.7, 2.4, 0, "booth"),
    (-9.0, -6.6, -90, False, 5.3, 2.4, 0, "copy room"),
    (-1.1, -6.6, 90, False, 5.4, 5.5, 0, "stairs"),
    (-1.1, -9.25, 90, False, 2.65, 5.5, 90, "toilets"),
    (-1.1, -9.25, 90, True, 2.65, 5.5, 90, "toilets"),
    (1.1, -1.2, 180, True, 4.4, 4.8, 100, "solo"),
    (10.0, -1.2, 180, False, 4.5, 4.8, 0, "corner"),
    (1.1, -6.0, -90, False, 5.9, 8.9, 90, "training"),
    (19.0, -1.2, 180, False, 9.0, 10.7, 90, "workshop"),
    (27.5, -1.2, 180, False, 7.0, 4.5, 0, "team"),
    (27.5, -1.2, 180, True, 7.0, 4.5, 105, "team"),
    (24.2, -7.2, 180, False, 5.2, 4.7, 90, "pair"),
    (24.2, -7.2, 180, True, 5.2, 4.7, 0, "row"),
    (34.5, -7.2, 180, False, 5.1, 4.7, 70, "store"),
]
# fmt: on

OUTER = [(-29.5, -11.9), (34.5, -11.9), (34.5, 7.2), (28.5, 7.2), (28.5, 11.9), (-29.5, 11.9)]
OPENINGS = [(24.0, 1.2, 0, 2.0), (20.0, 6.5, 90, 1.2), (10.8, -1.2, 0, 1.0)]  # x, y, angle, width


@dataclass(frozen=True)
class Pen:
    """A pen that draws in a frame of its own."""

    pixels: Any  # Pillow's pixel access
    dice: random.Random  # moves the chairs a little; seeded, so every picture is the same
    x: float = 0.0
    y: float = 0.0
    yaw: float = 0.0  # radians
    side: int = 1  # -1 swaps left and right

    def at(self, u: float, v: float, degrees: float = 0.0, mirrored: bool = False) -> Pen:
        """Return a pen with its frame at (u, v), turned by `degrees`, then mirrored."""
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        return replace(
            self,
            x=self.x + c * self.side * u - s * v,
            y=self.y + s * self.side * u + c * v,
            yaw=self.yaw + self.side * math.radians(degrees),
            side=-self.side if mirrored else self.side,
        )

    def draw(self, what: str, u: float, v: float, degrees: float, *size: float) -> None:
        """Draw a block, an oval or one of PARTS."""
        pen = self.at(u, v, degrees)
        if what == "block":
            pen.block(*size)
        elif what == "oval":
            pen.paint(*size, lambda p, q: math.hypot(2 * p / size[0], 2 * q / size[1]) <= 1.0)
        else:
            if what == "chair":
                pen = pen.at(self.dice.uniform(-0.12, 0.12), self.dice.uniform(-0.08, 0.08))
            for part in PARTS[what]:
                pen.draw(*part)

    def block(self, w: float, d: float, corner: float = 0.0, grey: int = OCCUPIED) -> None:
        """Paint a w x d rectangle, its corners rounded with the radius `corner`."""

        def inside(p: float, q: float) -> bool:
            over_u, over_v = abs(p) - w / 2 + corner, abs(q) - d / 2 + corner
            return math.hypot(max(over_u, 0.0), max(over_v, 0.0)) <= corner + 1e-9

        self.paint(w, d, inside, grey)

    def paint(
        self, w: float, d: float, inside: Callable[[float, float], bool], grey: int = OCCUPIED
    ) -> None:
        """Paint each pixel of the w x d box about the origin with a centre that is `inside`."""
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        reach_x, reach_y = (abs(c) * w + abs(s) * d) / 2, (abs(s) * w + abs(c) * d) / 2
        column = math.floor((self.x - reach_x - ORIGIN[0]) / RESOLUTION)
        row = math.floor((self.y - reach_y - ORIGIN[1]) / RESOLUTION)
        for i in range(column, column + math.ceil(2 * reach_x / RESOLUTION) + 1):
            for j in range(row, row + math.ceil(2 * reach_y / RESOLUTION) + 1):
                dx = ORIGIN[0] + (i + 0.5) * RESOLUTION - self.x
                dy = ORIGIN[1] + (j + 0.5) * RESOLUTION - self.y
                if inside(self.side * (c * dx + s * dy), c * dy - s * dx):
                    self.pixels[i, SIZE[1] - 1 - j] = grey

    def wall(self, start: tuple[float, float], end: tuple[float, float], thick: float) -> None:
        """Draw a wall along x or y."""
        (x1, y1), (x2, y2) = start, end
        pen = self.at((x1 + x2) / 2, (y1 + y2) / 2)
        pen.block(abs(x2 - x1) + thick, abs(y2 - y1) + thick)


def draw_office() -> Image.Image:
    """Return the whole floor: walls first, then the doors in them, then what is in rooms."""
    image = Image.new("L", SIZE, FREE)
    world = Pen(image.load(), random.Random(1))
    rooms = [(world.at(x, y, a, mirrored), *rest) for x, y, a, mirrored, *rest in ROOMS]

    for start, end in zip(OUTER, OUTER[1:] + OUTER[:1]):
        world.wall(start, end, 0.2)
    for pen, w, d, _, _ in rooms:
        for start, end in [((0, 0), (w, 0)), ((w, 0), (w, d)), ((w, d), (0, d)), ((0, d), (0, 0))]:
            pen.wall(start, end, 0.1)
    for x, y, angle, width in OPENINGS:
        world.at(x, y, angle).block(width, 0.1, grey=FREE)
    for pen, _, _, leaf, what in rooms:
        pen.at(0.8, 0).block(0.9, 0.1, grey=FREE)
        if leaf:
            pen.at(0.35, 0, leaf).at(0.45, 0).block(0.9, 0.08)
        for part in PARTS[what]:
            pen.draw(*part)
    for part in PARTS["open plan"] + PARTS["lobby"]:
        world.draw(*part)
    return image


if __name__ == "__main__":
    draw_office().save(Path(__file__).with_name("office.png"), optimize=True)
