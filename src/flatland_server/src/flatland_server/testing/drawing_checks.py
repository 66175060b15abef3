"""A check of a plugin's drawing in pictures. It yields the problems that it finds."""

from PIL import Image

from flatland_server.plugins.plugin import Plugin
from flatland_server.rendering.image_canvas import ImageCanvas
from flatland_server.rendering.view import View
from flatland_server.testing.behaviour_checks import SECONDS, Problems, content_of, state_of
from flatland_server.testing.checked_plugin import CheckedPlugin


def check_drawing(case: CheckedPlugin) -> Problems:
    """A plugin that draws itself does so without an error, and pictures change nothing."""
    runs = [case.load(seed=7) for _ in range(2)]
    world = runs[1].simulation.world
    plugins = [each for owner in ["", *world.models] for each in world.plugins_of(owner).values()]
    if all(type(plugin).draw is Plugin.draw for plugin in plugins):
        return
    runs[1].simulation.allow_failures = True
    canvas = ImageCanvas(Image.new("RGB", (64, 64)), View.around((0.0, 0.0), 8.0, (64, 64)))
    for _ in range(3):
        world.contents.plugins.draw(canvas, runs[1].simulation.timekeeper)
        for run in runs:
            run.go(SECONDS / 5)
    for failure in world.plugin_failures:
        yield f"expected to draw itself, found {failure.reason}"
    if [content_of(runs[0]), state_of(runs[0])] != [content_of(runs[1]), state_of(runs[1])]:
        yield "expected the same run with pictures as without, found a difference"
