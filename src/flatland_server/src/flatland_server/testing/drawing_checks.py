"""A check of a plugin's drawing in pictures. It yields the problems that it finds."""

import inspect
from typing import Any, Callable

import numpy as np

from flatland_server.canvas import Canvas
from flatland_server.plugins.plugin import Plugin
from flatland_server.testing.behaviour_checks import SECONDS, Problems, content_of, state_of
from flatland_server.testing.checked_plugin import CheckedPlugin

_COLUMNS = {"corners": 2, "points": 2, "center": 2, "point": 2, "segments": 4}
"""The numbers of a row, by the names of a canvas's parameters."""

_COLORS = ("fill", "outline", "color")


class CheckingCanvas:
    """A `Canvas` that draws nothing, and raises the errors of wrong shapes and colours."""

    def __getattr__(self, name: str) -> Callable[..., None]:
        signature = inspect.signature(getattr(Canvas, name))

        def draw(*arguments: Any, **named: Any) -> None:
            _, *given = signature.bind(self, *arguments, **named).arguments.items()
            for parameter, value in given:
                if parameter in _COLORS:
                    np.asarray((0.0,) * 4 if value is None else value, dtype=float).reshape(4)
                elif parameter != "text":
                    np.asarray(value, dtype=float).reshape(-1, _COLUMNS.get(parameter, 1))

        return draw


def check_drawing(case: CheckedPlugin) -> Problems:
    """A plugin that draws itself does so without an error, and pictures change nothing."""
    runs = [case.load(seed=7) for _ in range(2)]
    world = runs[1].simulation.world
    plugins = [each for owner in ["", *world.models] for each in world.plugins_of(owner).values()]
    if all(type(plugin).draw is Plugin.draw for plugin in plugins):
        return
    runs[1].simulation.allow_failures = True
    canvas: Any = CheckingCanvas()
    for _ in range(3):
        world.contents.plugins.draw(canvas, runs[1].simulation.timekeeper)
        for run in runs:
            run.go(SECONDS / 5)
    for failure in world.plugin_failures:
        yield f"expected to draw itself, found {failure.reason}"
    if [content_of(runs[0]), state_of(runs[0])] != [content_of(runs[1]), state_of(runs[1])]:
        yield "expected the same run with pictures as without, found a difference"
