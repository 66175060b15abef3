"""The rviz configuration of the window, made of `flatland.rviz`."""

from copy import deepcopy
from typing import Any, Dict

from flatland_viz.navigation_tools import NAVIGATION_TOOLS

Config = Dict[str, Any]

_PER_WORLD = ("rviz/MarkerArray", "rviz/LaserScan", "rviz/InteractiveMarkers")
_PANELS = (
    {"Class": "rviz/Displays", "Name": "Displays"},
    {"Class": "rviz/Tool Properties", "Name": "Tool Properties"},
)
_LEFT_OUT = (
    "rviz/Select",
    "rviz/FocusCamera",
    "rviz/MoveCamera",
    *(tool.kind for tool in NAVIGATION_TOOLS),
)
"""Tools of little use in a view from above, and tools that are added on demand."""

INTERACT_TOOL = "flatland_viz/Interact"
"""The tool for models and the view, in place of rviz's."""

MODELS = "flatland_viz/Models"
"""The display of the models, one for the window's whole life."""
VIEW = "flatland_viz/MapView"
"""The view: rviz's TopDownOrtho with the mouse of maps."""


def for_window(base: Config, frame_rate: int) -> Config:
    """`base` without the displays of a world, which are added when the world is known.

    Panels are replaced, and the geometry of rviz's own window is left out.

    Args:
        base: the configuration to start from.
        frame_rate: how often the view is drawn [Hz].
    """
    config = deepcopy(base)
    config["Panels"] = deepcopy(list(_PANELS))
    config.pop("Window Geometry", None)
    manager = config["Visualization Manager"]
    manager["Global Options"]["Frame Rate"] = frame_rate
    manager["Displays"] = [d for d in manager["Displays"] if d["Class"] not in _PER_WORLD]
    manager["Displays"].append({"Class": MODELS, "Name": "Models", "Enabled": True, "Value": True})
    manager["Tools"] = [
        {"Class": INTERACT_TOOL} if tool["Class"] == "rviz/Interact" else tool
        for tool in manager["Tools"]
        if tool["Class"] not in _LEFT_OUT
    ]
    manager["Views"]["Current"]["Class"] = VIEW
    return config
