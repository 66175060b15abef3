"""Pictures of runs: where the robot has been, on the map, as everything was at the end."""

from typing import Tuple

import numpy as np

from flatland_server.canvas import Canvas, Rgba
from flatland_server.geometry import Point
from flatland_server.rendering.image_canvas import ImageCanvas
from flatland_server.rendering.renderer import Renderer, to_png
from flatland_server.rendering.view import View, fitting_size
from flatland_server.sweep.run import RunObserver, SweepRun
from flatland_server.sweep.runner import ScenarioRunner
from flatland_server.sweep.scenario import Scenario

_LONGER_SIDE = 480  # px
_ROOM = 3.0  # m, around the path and the goal
_LEAST_ASPECT = 0.4
_GOAL: Rgba = (0.2, 0.65, 0.3, 0.35)
_GOAL_OUTLINE: Rgba = (0.1, 0.5, 0.2, 0.9)
_GOAL_WIDTH = 1.5  # px
_START: Rgba = (0.2, 0.5, 0.8, 1.0)
_START_SIZE = 9.0  # px


def picture_of(runner: ScenarioRunner, scenario: Scenario) -> bytes:
    """Runs a scenario again, and draws it.

    Returns:
        The content of a PNG file; empty if the world cannot be loaded or has no robot.
    """
    artist = _Artist()
    runner.run(scenario, artist)
    return artist.picture


class _Artist(RunObserver):
    """Draws a run at its end."""

    picture = b""

    def on_end(self, run: SweepRun) -> None:
        self.picture = draw_run(run)


def draw_run(run: SweepRun) -> bytes:
    """A picture of a run as it is now: the content of a PNG file; empty without a robot."""
    if not run.path:
        return b""
    renderer = Renderer(run.simulation.world, run.simulation.timekeeper)
    low, high = _corners(run)
    view = View.of(low, high, fitting_size(low, high, _LONGER_SIDE))
    image = renderer.image(view, trails=[run.path])
    canvas = ImageCanvas(image, view)
    canvas.dots([run.path[0]], _START, _START_SIZE)
    draw_goal(canvas, run)
    return to_png(image)


def draw_goal(canvas: Canvas, run: SweepRun) -> None:
    """Draws where the robot is to go."""
    if run.goal is not None:
        canvas.disc(run.goal, run.goal_radius, _GOAL, _GOAL_OUTLINE, _GOAL_WIDTH)


def _corners(run: SweepRun) -> Tuple[Point, Point]:
    """The lower left and the upper right corner of what a picture shows [m]."""
    places = np.array([*run.path, *([run.goal] if run.goal else [])])
    low, high = places.min(axis=0) - _ROOM, places.max(axis=0) + _ROOM
    least = _LEAST_ASPECT * float((high - low).max())
    for side in (0, 1):
        missing = max(0.0, least - (high[side] - low[side]))
        low[side] -= missing / 2
        high[side] += missing / 2
    return (float(low[0]), float(low[1])), (float(high[0]), float(high[1]))
