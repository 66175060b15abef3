"""The displays of a world in the window.

Pure functions of the topics that the ROS master lists.
"""

from typing import Iterable, List, NamedTuple, Tuple

from flatland_teleop.natural_order import natural_key

BODIES = "flatland_viz/Bodies"
SCAN = "flatland_viz/Scan"
WALLS = "flatland_viz/Walls"

FOOTPRINTS = "models"
"""The name of the display with the models' bodies."""
SCAN_TYPE = "sensor_msgs/LaserScan"


class Shown(NamedTuple):
    """A display: its name in rviz, its class, and its topic."""

    name: str
    kind: str
    topic: str


def laser_scans(published: Iterable[Tuple[str, str]]) -> List[str]:
    """The topics with laser scans, in natural order, of pairs of a topic and its type."""
    return sorted((topic for topic, kind in published if kind == SCAN_TYPE), key=natural_key)


def walls_topic(debug: str) -> str:
    """The topic with the walls of all layers.

    Args:
        debug: the namespace of the server's markers, `/flatland_server/debug`.
    """
    return f"{debug}/walls"


def wanted(debug: str, scans: Iterable[str]) -> List[Shown]:
    """All displays of a world.

    All layers share one display, since several topics of `~debug/topics` show the same walls. All
    models share one too, which stays when models come and go.

    Args:
        debug: the namespace of the server's markers, `/flatland_server/debug`.
        scans: topics of laser scans.
    """
    return [
        Shown("layers", WALLS, walls_topic(debug)),
        Shown(FOOTPRINTS, BODIES, f"{debug}/models"),
        *(Shown(topic.lstrip("/"), SCAN, topic) for topic in scans),
    ]


def changes(shown: Iterable[Shown], wanted: Iterable[Shown]) -> Tuple[List[Shown], List[Shown]]:
    """The displays to remove, and the displays to add, in order."""
    old, new = list(shown), list(wanted)
    return [one for one in old if one not in new], [one for one in new if one not in old]
