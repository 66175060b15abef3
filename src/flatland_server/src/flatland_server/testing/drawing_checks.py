"""A check of a plugin's drawing in pictures. It yields the problems that it finds."""

from typing import Any, Optional

import numpy as np

from flatland_server.canvas import Canvas, Points, Rgba
from flatland_server.geometry import Point
from flatland_server.plugins.plugin import Plugin
from flatland_server.testing.behaviour_checks import SECONDS, Problems, content_of, state_of
from flatland_server.testing.checked_plugin import CheckedPlugin


class CheckingCanvas(Canvas):
    """Draws nothing, and raises the errors that a picture raises for wrong shapes and colours."""

    def area(
        self,
        corners: Points,
        fill: Optional[Rgba] = None,
        outline: Optional[Rgba] = None,
        width: float = 1.0,
    ) -> None:
        _check(corners, 2, fill, outline, width)

    def disc(
        self,
        center: Point,
        radius: float,
        fill: Optional[Rgba] = None,
        outline: Optional[Rgba] = None,
        width: float = 1.0,
    ) -> None:
        _check([center], 2, fill, outline, radius, width)

    def lines(self, segments: Any, color: Rgba, width: float = 1.0) -> None:
        _check(segments, 4, color, None, width)

    def path(self, points: Points, color: Rgba, width: float = 1.0) -> None:
        _check(points, 2, color, None, width)

    def dots(self, points: Points, color: Rgba, size: float = 3.0) -> None:
        _check(points, 2, color, None, size)

    def label(self, point: Point, text: str, color: Rgba) -> None:
        _check([point], 2, color, None, len(text))


def _check(
    rows: Any, columns: int, color: Optional[Rgba], other: Optional[Rgba], *lengths: float
) -> None:
    np.asarray(rows, dtype=float).reshape(-1, columns)
    for each in (color, other):
        if each is not None:
            np.asarray(each, dtype=float).reshape(4)
    np.asarray(lengths, dtype=float)


def check_drawing(case: CheckedPlugin) -> Problems:
    """A plugin that draws itself does so without an error, and pictures change nothing."""
    runs = [case.load(seed=7) for _ in range(2)]
    world = runs[1].simulation.world
    plugins = [each for owner in ["", *world.models] for each in world.plugins_of(owner).values()]
    if all(type(plugin).draw is Plugin.draw for plugin in plugins):
        return
    runs[1].simulation.allow_failures = True
    for _ in range(3):
        world.contents.plugins.draw(CheckingCanvas(), runs[1].simulation.timekeeper)
        for run in runs:
            run.go(SECONDS / 5)
    for failure in world.plugin_failures:
        yield f"expected to draw itself, found {failure.reason}"
    if [content_of(runs[0]), state_of(runs[0])] != [content_of(runs[1]), state_of(runs[1])]:
        yield "expected the same run with pictures as without, found a difference"
