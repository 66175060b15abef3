"""Draws a world in a Matplotlib figure, as the background of a notebook's plots."""

from typing import Any, Optional

from flatland2d.rendering.renderer import Renderer
from flatland2d.rendering.view import View
from flatland_server.exceptions import MissingPackageError


def plot(
    renderer: Renderer,
    ax: Optional[Any] = None,
    view: Optional[View] = None,
    *,
    sensors: bool = False,
    names: bool = False,
) -> Any:
    """Draws a world into Matplotlib axes, which are in metres.

    Args:
        renderer: the world's renderer.
        ax: the axes; by default those that pyplot has at present.
        view: the section to show; by default the whole world.
        sensors: as for `Renderer.image`.
        names: as for `Renderer.image`.

    Returns:
        The axes.

    Raises:
        FlatlandError: Matplotlib is not installed.
    """
    if ax is None:
        try:
            from matplotlib import pyplot
        except ImportError:
            raise MissingPackageError("a plot needs Matplotlib: pip install matplotlib") from None
        ax = pyplot.gca()
    view = view or renderer.view()
    image = renderer.image(view, sensors=sensors, names=names)
    ax.imshow(image, extent=view.extent, interpolation="antialiased")
    ax.set_xlabel("x [m]")
    ax.set_ylabel("y [m]")
    return ax
