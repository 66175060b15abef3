"""Numbers of messages by their path, such as `twist.twist.linear.x` or `ranges[0]`."""

import math
import re
from typing import Any, Dict, List, Optional, Tuple

NEAREST = "nearest"
"""A path of scans alone: the smallest range that hits something [m]."""

_CURVES: Dict[str, Tuple[str, ...]] = {
    "flatland_msgs/SimulationState": ("real_time_factor",),
    "geometry_msgs/Twist": ("linear.x", "angular.z"),
    "geometry_msgs/TwistStamped": ("twist.linear.x", "twist.angular.z"),
    "geometry_msgs/TwistWithCovarianceStamped": ("twist.twist.linear.x", "twist.twist.angular.z"),
    "nav_msgs/Odometry": ("twist.twist.linear.x", "twist.twist.angular.z"),
    "sensor_msgs/Imu": ("angular_velocity.z", "linear_acceleration.x"),
    "sensor_msgs/LaserScan": (NEAREST,),
    "sensor_msgs/NavSatFix": ("latitude", "longitude"),
}
"""The paths that are plotted of a topic without one, by type."""

_PART = re.compile(r"(\w+)|\[(-?\d+)\]")
_MOST = 6  # curves of other types
_SCAN = "sensor_msgs/LaserScan"


def split(name: str, topics: Dict[str, str]) -> Tuple[str, str]:
    """A topic, and the path in its messages; both empty while no such topic is there.

    Args:
        name: such as `/odom/twist/twist/linear/x`, `/odom.twist.twist.linear.x` or `/odom`.
        topics: the types of topics by their names.
    """
    for topic in sorted(topics, key=len, reverse=True):
        rest = name[len(topic) :]
        if name.startswith(topic) and (not rest or rest[0] in "/.["):
            return topic, rest.replace("/", ".").lstrip(".")
    return "", ""


def paths_of(kind: str, message: Any, path: str) -> List[str]:
    """The paths of the numbers that a path stands for: itself, or those below it.

    Args:
        kind: the type, such as `nav_msgs/Odometry`.
        message: a message of this type.
        path: empty for the whole message.
    """
    if not path and kind in _CURVES:
        return list(_CURVES[kind])
    if value_of(message, path) is not None:
        return [path]
    return _numbers_in(_at(message, path), path)[:_MOST]


def value_of(message: Any, path: str) -> Optional[float]:
    """The number at a path of a message; None if there is none."""
    if path == NEAREST and getattr(message, "_type", "") == _SCAN:
        low, high = message.range_min, message.range_max
        return min((each for each in message.ranges if low <= each <= high), default=math.nan)
    value = _at(message, path)
    if isinstance(value, (bool, int, float)):
        return float(value)
    to_sec = getattr(value, "to_sec", None)
    return float(to_sec()) if to_sec is not None else None


def _at(message: Any, path: str) -> Any:
    value = message
    for match in _PART.finditer(path):
        try:
            value = getattr(value, match[1]) if match[1] else value[int(match[2])]
        except (AttributeError, IndexError, TypeError):
            return None
    return value


def _numbers_in(value: Any, path: str) -> List[str]:
    found: List[str] = []
    for name in getattr(value, "__slots__", ()):
        inner = f"{path}.{name}" if path else name
        if name in ("header", "stamp") or name.startswith("_"):
            continue
        if value_of(value, name) is not None:
            found.append(inner)
        else:
            found += _numbers_in(getattr(value, name), inner)
    return found
