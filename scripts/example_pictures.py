"""Draws the examples while they run, and the README's moving picture."""

import sys
from pathlib import Path

import numpy as np
from example_run import EXAMPLES, PERIOD, ExampleRun
from PIL import Image

from flatland2d.rendering.image_canvas import ImageCanvas
from flatland2d.rendering.renderer import Renderer
from flatland2d.sweep.report import draw_goal
from flatland2d.sweep.run import RunObserver
from flatland2d.sweep.runner import ScenarioRunner
from flatland2d.sweep.scenario_file import read_scenario_file
from flatland2d.sweep.settings import scenario_of

MOVING = Path(__file__).resolve().parents[1] / "docs" / "images" / "flatland.gif"
PICTURES = {  # launch arguments, time [s], and options of the drawing
    "office_tour": ((), 18.0, {"follow": "turtlebot", "width": 16, "size": (900, 560)}),
    "tricycle_trailer": ((), 12.0, {"size": (900, 600)}),
    "automatic_door": ((), 6.0, {"size": (900, 360)}),
    "warehouse": ((), 20.0, {"size": (900, 600)}),
    "crowd": ((), 14.0, {"size": (900, 240)}),
    "navigation": (("robots:=2",), 8.0, {"follow": "r1", "width": 22, "size": (900, 440)}),
    "racecar": ((), 12.0, {"size": (900, 480)}),
    "training": ((), 0.0, {"size": (600, 600)}),
}
SWEEPS = {  # scenarios, and the size of the picture of each
    "sweep": ((11, 31, 51), (360, 360)),  # one task, with each controller and a noisy lidar
    "mppi": ((1,), (900, 360)),
}
FRAMES, FRAME_PERIOD = 60, 0.2  # s of simulated time
FRAME_DURATION = 100  # ms
MOVING_SIZE = (760, 420)


def main(names):
    """Draws examples; all of them and the moving picture, unless some are named."""
    for name in names or [*PICTURES, *SWEEPS]:
        if name in SWEEPS:
            draw_sweep(name)
            continue
        arguments, time, options = PICTURES[name]
        run = ExampleRun(name, *arguments)
        while run.simulation.time < time:
            run.step()
        run.simulation.save_picture(EXAMPLES / name / "picture.png", sensors=True, **options)
        run.close()
    if not names:
        draw_moving_picture()


class Artist(RunObserver):
    """Draws the whole world of a run at its end, with the path of its robot."""

    pixels = None

    def __init__(self, size):
        self.size = size

    def on_end(self, run):
        renderer = Renderer(run.simulation.world, run.simulation.timekeeper)
        view = renderer.view(self.size)
        image = renderer.image(view, trails=[run.path])
        draw_goal(ImageCanvas(image, view), run)
        self.pixels = np.asarray(image.convert("RGB"))


def draw_sweep(name):
    """Runs of a sweep, side by side."""
    numbers, size = SWEEPS[name]
    settings = read_scenario_file(EXAMPLES / name / "scenarios.yaml")
    runner = ScenarioRunner(settings)
    pictures = []
    for number in numbers:
        artist = Artist(size)
        runner.run(scenario_of(settings, number), artist)
        pictures.append(artist.pixels)
    picture = Image.fromarray(np.hstack(pictures))
    picture.save(EXAMPLES / name / "picture.png", optimize=True)


def draw_moving_picture():
    """The robot of the office on its tour, with its lidar, twice as fast as real time."""
    run = ExampleRun("office_tour")
    frames = []
    for _ in range(FRAMES):
        for _ in range(round(FRAME_PERIOD / PERIOD)):
            run.step()
        pixels = run.simulation.render(MOVING_SIZE, follow="turtlebot", width=15, sensors=True)
        frames.append(Image.fromarray(pixels).quantize(48, dither=Image.Dither.NONE))
    frames[0].save(
        MOVING,
        save_all=True,
        append_images=frames[1:],
        duration=FRAME_DURATION,
        loop=0,
        optimize=True,
    )
    run.close()


main(sys.argv[1:])
