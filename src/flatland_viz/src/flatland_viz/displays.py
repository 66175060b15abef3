"""What the window shows of a world: displays that come and go with its layers and scans.

Pure: which displays there should be, given what the server and the ROS master list.
"""

from typing import Iterable, List, NamedTuple, Tuple

MARKERS = "rviz/MarkerArray"
SCAN = "rviz/LaserScan"
HANDLES = "rviz/InteractiveMarkers"

TOPIC_PROPERTIES = {MARKERS: "Marker Topic", SCAN: "Topic", HANDLES: "Update Topic"}
"""What rviz calls the topic, by the class of a display."""


class Shown(NamedTuple):
    """A display: how rviz lists it, its class, and its topic."""

    name: str
    kind: str
    topic: str


def laser_scans(published: Iterable[Tuple[str, str]]) -> List[str]:
    """The topics with laser scans, of pairs of a topic and its type, in order."""
    return sorted(topic for topic, kind in published if kind == "sensor_msgs/LaserScan")


def layer_topics(debug: str, listed: Iterable[str]) -> List[str]:
    """The topics of the layers' markers.

    Args:
        debug: the namespace of the server's markers, `/flatland_server/debug`.
        listed: what the server lists on `~debug/topics`: `layer/<name>` and `model/<name>`.
    """
    return [f"{debug}/{topic}" for topic in listed if topic.startswith("layer/")]


def wanted(debug: str, handles: str, listed: Iterable[str], scans: Iterable[str]) -> List[Shown]:
    """All displays of a world. Models share one, so that it need not follow who comes and goes.

    Args:
        debug: the namespace of the server's markers, `/flatland_server/debug`.
        handles: the topic of the interactive markers.
        listed: what the server lists on `~debug/topics`.
        scans: topics of laser scans.
    """
    return [
        *(Shown(topic[len(debug) + 1 :], MARKERS, topic) for topic in layer_topics(debug, listed)),
        Shown("models", MARKERS, f"{debug}/models"),
        Shown("drag and turn", HANDLES, handles),
        *(Shown(topic.lstrip("/"), SCAN, topic) for topic in scans),
    ]


def changes(shown: Iterable[Shown], wanted: Iterable[Shown]) -> Tuple[List[Shown], List[Shown]]:
    """What to take away and what to add, in order. What stays is in neither list."""
    old, new = list(shown), list(wanted)
    return [one for one in old if one not in new], [one for one in new if one not in old]
