"""The rviz configuration of the window: that of `flatland.rviz`, without a world of its own."""

from copy import deepcopy
from typing import Any, Dict, List

from flatland_viz.displays import HANDLES, MARKERS, SCAN, TOPIC_PROPERTIES, Shown

Config = Dict[str, Any]

_PER_WORLD = (MARKERS, SCAN, HANDLES)
_PANELS = (
    {"Class": "rviz/Displays", "Name": "Displays"},
    {"Class": "rviz/Tool Properties", "Name": "Tool Properties"},
)
_LEFT_OUT = ("rviz/Select", "rviz/FocusCamera")
"""Tools that are of little use from above, and would not find room in a window of 1024 pixels."""

_POINT_SIZE = "Size (Pixels)"


def for_window(base: Config) -> Config:
    """`base` without the displays of a world: those are made when the world is known.

    Panels are ours, and the geometry of rviz's own window is left out.
    """
    config = deepcopy(base)
    config["Panels"] = deepcopy(list(_PANELS))
    config.pop("Window Geometry", None)
    manager = config["Visualization Manager"]
    manager["Displays"] = [d for d in manager["Displays"] if d["Class"] not in _PER_WORLD]
    manager["Tools"] = [tool for tool in manager["Tools"] if tool["Class"] not in _LEFT_OUT]
    return config


def for_display(base: Config, shown: Shown, pixel_ratio: float = 1.0) -> Config:
    """The configuration of one display: like the first of its class in `base`, if there is one.

    Args:
        base: the configuration to start from.
        shown: the display.
        pixel_ratio: how many pixels of the screen are as wide as one of an ordinary screen.
    """
    displays: List[Config] = base["Visualization Manager"]["Displays"]
    patterns = {display["Class"]: display for display in reversed(displays)}
    config = {
        **deepcopy(patterns.get(shown.kind, {})),
        "Class": shown.kind,
        "Name": shown.name,
        "Enabled": True,
        "Value": True,
        TOPIC_PROPERTIES[shown.kind]: shown.topic,
    }
    if _POINT_SIZE in config:
        config[_POINT_SIZE] *= pixel_ratio
    return config
