"""The displays of a world in the window.

Pure functions of the topics that the ROS master lists.
"""

from typing import Container, Dict, Iterable, List, NamedTuple, Tuple

from flatland_teleop.natural_order import natural_key

BODIES = "flatland_viz/Bodies"
GOAL = "rviz/Pose"
PLAN = "rviz/Path"
SCAN = "flatland_viz/Scan"
WALLS = "flatland_viz/Walls"

COLORED = (GOAL, PLAN, SCAN)
"""Displays with the colour of a robot."""
FOOTPRINTS = "models"
"""The name of the display with the models' bodies."""
SCAN_TYPE = "sensor_msgs/LaserScan"
_KINDS = {SCAN_TYPE: SCAN, "nav_msgs/Path": PLAN, "geometry_msgs/PoseStamped": GOAL}
_GOAL, _SIMPLE_GOAL = "/move_base/current_goal", "/move_base_simple/goal"


class Shown(NamedTuple):
    """A display: its name in rviz, its class, and its topic."""

    name: str
    kind: str
    topic: str


def of_topics(published: Iterable[Tuple[str, str]], tf: str = "/tf") -> List[Shown]:
    """The displays of laser scans, plans and goals, in natural order.

    Scans in a namespace with transforms of its own (`<namespace>/tf`) are shown only with these.

    Goals are those of move_base's topic `current_goal`. Those of `move_base_simple/goal` are shown
    where nothing publishes that.

    Args:
        published: pairs of a topic and its type.
        tf: the topic of the transforms that the window has.
    """
    kinds = dict(published)
    displays = [
        Shown(topic.lstrip("/"), _KINDS[kind], topic)
        for topic, kind in kinds.items()
        if kind in _KINDS and (kind != SCAN_TYPE or _tf_of(topic, kinds, tf) == tf)
    ]
    goals = {display.topic for display in displays if display.topic.endswith(_GOAL)}

    def is_wanted(kind: str, topic: str) -> bool:
        if kind != GOAL or not topic.endswith(_SIMPLE_GOAL):
            return kind != GOAL or topic in goals
        return f"{topic[: -len(_SIMPLE_GOAL)]}{_GOAL}" not in goals

    wanted = [display for display in displays if is_wanted(display.kind, display.topic)]
    return sorted(wanted, key=lambda display: natural_key(display.topic))


def _tf_of(topic: str, published: Container[str], default: str) -> str:
    """The topic of transforms in the nearest namespace above a topic that has one."""
    while topic:
        topic = topic.rpartition("/")[0]
        if f"{topic}/tf" in published:
            return f"{topic}/tf"
    return default


def walls_topic(debug: str) -> str:
    """The topic with the walls of all layers.

    Args:
        debug: the namespace of the server's markers, `/flatland_server/debug`.
    """
    return f"{debug}/walls"


def wanted(debug: str, others: Iterable[Shown]) -> List[Shown]:
    """All displays of a world.

    All layers share one display, since several topics of `~debug/topics` show the same walls. All
    models share one too, which stays when models come and go.

    Args:
        debug: the namespace of the server's markers, `/flatland_server/debug`.
        others: displays of the topics of robots.
    """
    return [
        Shown("layers", WALLS, walls_topic(debug)),
        Shown(FOOTPRINTS, BODIES, f"{debug}/models"),
        *others,
    ]


def color_of(topic: str, colors: Dict[str, str]) -> str:
    """The colour of a topic, or of the next namespace above it that has one; else empty.

    Args:
        topic: absolute name of the topic, such as "/robot1/scan".
        colors: of topics and namespaces; that of the root is the empty string.
    """
    while topic and topic not in colors:
        topic = topic.rpartition("/")[0]
    return colors.get(topic, "")


def changes(shown: Iterable[Shown], wanted: Iterable[Shown]) -> Tuple[List[Shown], List[Shown]]:
    """The displays to remove, and the displays to add, in order."""
    old, new = list(shown), list(wanted)
    return [one for one in old if one not in new], [one for one in new if one not in old]
