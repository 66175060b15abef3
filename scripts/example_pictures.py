"""Draws the examples while they run, and the README's moving picture."""

import sys
from pathlib import Path

from example_run import EXAMPLES, PERIOD, ExampleRun
from PIL import Image

MOVING = Path(__file__).resolve().parents[1] / "docs" / "images" / "flatland.gif"
PICTURES = {  # the arguments of the launch file, the time [s], and what is drawn
    "office_tour": ((), 18.0, {"follow": "turtlebot", "width": 16, "size": (900, 560)}),
    "tricycle_trailer": ((), 12.0, {"size": (900, 600)}),
    "automatic_door": ((), 6.0, {"size": (900, 360)}),
    "warehouse": ((), 20.0, {"size": (900, 600)}),
    "crowd": ((), 14.0, {"size": (900, 240)}),
    "navigation": (("robots:=2",), 8.0, {"follow": "r1", "width": 22, "size": (900, 440)}),
    "training": ((), 0.0, {"size": (600, 600)}),
}
FRAMES, FRAME_PERIOD = 60, 0.2  # s of simulated time
FRAME_DURATION = 100  # ms
MOVING_SIZE = (760, 420)


def main(names):
    """Draws examples; all of them and the moving picture, unless some are named."""
    for name in names or PICTURES:
        arguments, time, options = PICTURES[name]
        run = ExampleRun(name, *arguments)
        while run.simulation.time < time:
            run.step()
        run.simulation.save_picture(EXAMPLES / name / "picture.png", sensors=True, **options)
        run.close()
    if not names:
        draw_moving_picture()


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
