"""Deprecated: a picture of a world; `Renderer(world).image(names=True)` makes it."""

from PIL import Image

from flatland_server.rendering.renderer import Renderer
from flatland_server.simulation.world import World


def render(world: World) -> Image.Image:
    """A picture of walls, footprints and names of models; its longer side has 1600 pixels."""
    return Renderer(world).image(names=True)
