"""An rviz configuration for the world that is running."""

from copy import deepcopy
from typing import Any, Dict, List, NamedTuple, Sequence

Config = Dict[str, Any]

_SHOWN_PER_WORLD = ("rviz/MarkerArray", "rviz/LaserScan")


class Bounds(NamedTuple):
    """What the view should show [m]."""

    min_x: float
    min_y: float
    max_x: float
    max_y: float


def for_world(
    base: Config, marker_topics: Sequence[str], scan_topics: Sequence[str], bounds: Bounds
) -> Config:
    """`base` with displays for these topics, and the view from above framed on the bounds.

    Args:
        base: a configuration with a MarkerArray and a LaserScan display, taken as patterns.
        marker_topics: absolute names of MarkerArray topics.
        scan_topics: absolute names of LaserScan topics.
        bounds: of the world.
    """
    config = deepcopy(base)
    manager = config["Visualization Manager"]
    displays: List[Config] = manager["Displays"]
    patterns = {display["Class"]: display for display in reversed(displays)}
    manager["Displays"] = [d for d in displays if d["Class"] not in _SHOWN_PER_WORLD]
    for topics, kind, key in (
        (marker_topics, "rviz/MarkerArray", "Marker Topic"),
        (scan_topics, "rviz/LaserScan", "Topic"),
    ):
        for topic in topics:
            name = topic.split("/debug/")[-1].lstrip("/")
            manager["Displays"].append({**patterns[kind], "Name": name, key: topic})

    view = manager["Views"]["Current"]
    window = config["Window Geometry"]
    width, height = bounds.max_x - bounds.min_x, bounds.max_y - bounds.min_y
    view["X"] = (bounds.min_x + bounds.max_x) / 2
    view["Y"] = (bounds.min_y + bounds.max_y) / 2
    # The panel of displays takes about a quarter of the window; a margin of a tenth remains.
    if width > 0 and height > 0:
        view["Scale"] = 0.9 * min(0.75 * window["Width"] / width, 0.85 * window["Height"] / height)
    return config
