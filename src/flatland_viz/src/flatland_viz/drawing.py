"""Cheap drawing of the view: only on changes, and without anti-aliasing where the processor draws
instead of a graphics card.
"""

import ctypes
from typing import Any

import rospy

RENDER_ON_CHANGE = "flatland_viz/RenderOnChange"
"""Our display that keeps rviz from drawing an unchanged view."""

_LIBRARY = "libflatland_viz_tools.so"


def limit_anti_aliasing() -> None:
    """Switches anti-aliasing off if OpenGL runs on the processor.

    To be called before rviz opens a window. With a broken installation it stays on.
    """
    try:
        library = ctypes.CDLL(_LIBRARY)
    except OSError as error:
        rospy.logwarn("%s; the window may be slow", error)
        return
    library.flatland_viz_limit_anti_aliasing()


def render_on_change(manager: Any) -> None:
    """Makes an rviz draw its view only when it changes."""
    display = manager.createDisplay(RENDER_ON_CHANGE, "render on change", True)
    display.setHidden(True)  # in the Displays panel: there is nothing to set
