"""The displays of a world in the window, by its layers and laser scans.

Pure functions of the topics that the server and the ROS master list.
"""

from typing import Iterable, List, NamedTuple, Tuple

MARKERS = "rviz/MarkerArray"
SCAN = "rviz/LaserScan"
HANDLES = "rviz/InteractiveMarkers"

TOPIC_PROPERTIES = {MARKERS: "Marker Topic", SCAN: "Topic", HANDLES: "Update Topic"}
"""The name of the topic's property in rviz, by the class of a display."""


class Shown(NamedTuple):
    """A display: its name in rviz, its class, and its topic."""

    name: str
    kind: str
    topic: str


def laser_scans(published: Iterable[Tuple[str, str]]) -> List[str]:
    """The topics with laser scans, sorted, of pairs of a topic and its type."""
    return sorted(topic for topic, kind in published if kind == "sensor_msgs/LaserScan")


def layer_topics(debug: str, listed: Iterable[str]) -> List[str]:
    """The topics of the layers' markers.

    Args:
        debug: the namespace of the server's markers, `/flatland_server/debug`.
        listed: the topics on `~debug/topics`: `layer/<name>` and `model/<name>`.
    """
    return [f"{debug}/{topic}" for topic in listed if topic.startswith("layer/")]


def wanted(debug: str, handles: str, listed: Iterable[str], scans: Iterable[str]) -> List[Shown]:
    """All displays of a world. All models share one, which need not change when they do.

    Args:
        debug: the namespace of the server's markers, `/flatland_server/debug`.
        handles: the topic of the interactive markers.
        listed: the topics on `~debug/topics`.
        scans: topics of laser scans.
    """
    return [
        *(Shown(topic[len(debug) + 1 :], MARKERS, topic) for topic in layer_topics(debug, listed)),
        Shown("models", MARKERS, f"{debug}/models"),
        Shown("drag and turn", HANDLES, handles),
        *(Shown(topic.lstrip("/"), SCAN, topic) for topic in scans),
    ]


def changes(shown: Iterable[Shown], wanted: Iterable[Shown]) -> Tuple[List[Shown], List[Shown]]:
    """The displays to remove and those to add, in order."""
    old, new = list(shown), list(wanted)
    return [one for one in old if one not in new], [one for one in new if one not in old]
