"""The last message of a topic, in a few words."""

import math
from typing import Any, Callable, Dict


def describe(kind: str, message: Any) -> str:
    """The main values of a message, for a line in a panel; empty for other types.

    Args:
        kind: the type, such as `nav_msgs/Odometry`.
        message: the message.
    """
    describer = _DESCRIBERS.get(kind)
    return describer(message) if describer else ""


def is_described(kind: str) -> bool:
    """True if `describe` knows a type."""
    return kind in _DESCRIBERS


def number(value: float, digits: int = 2) -> str:
    """A number without a negative zero."""
    text = f"{value:.{digits}f}"
    return text[1:] if text.startswith("-") and not float(text) else text


def velocity(forward: float, sideways: float, turn: float) -> str:
    """A planar velocity [m/s, m/s, rad/s]."""
    side = "left" if sideways > 0 else "right"
    across = f"{number(abs(sideways))} m/s to the {side}, " if abs(sideways) >= 0.005 else ""
    return f"{number(forward)} m/s, {across}{number(turn)} rad/s"


def position(x: float, y: float, yaw: float) -> str:
    """A pose [m, m, rad]."""
    degrees = math.degrees(math.remainder(yaw, math.tau))
    return f"{number(x)}, {number(y)} m, {number(degrees, 0)}\u00b0"


def _twist(message: Any) -> str:
    return velocity(message.linear.x, message.linear.y, message.angular.z)


def _odometry(message: Any) -> str:
    pose = message.pose.pose
    yaw = 2 * math.atan2(pose.orientation.z, pose.orientation.w)
    return position(pose.position.x, pose.position.y, yaw)


def _scan(message: Any) -> str:
    hits = [r for r in message.ranges if message.range_min <= r <= message.range_max]
    return f"nearest {number(min(hits))} m" if hits else "hits nothing"


def _collisions(message: Any) -> str:
    names = sorted({collision.entity_B for collision in message.collisions})
    return f"touches {', '.join(names)}" if names else "touches nothing"


def _fix(message: Any) -> str:
    return f"{message.latitude:.6f}\u00b0, {message.longitude:.6f}\u00b0"


def _imu(message: Any) -> str:
    return f"{number(message.angular_velocity.z)} rad/s"


_DESCRIBERS: Dict[str, Callable[[Any], str]] = {
    "flatland_msgs/Collisions": _collisions,
    "geometry_msgs/Twist": _twist,
    "geometry_msgs/TwistStamped": lambda message: _twist(message.twist),
    "geometry_msgs/TwistWithCovarianceStamped": lambda message: _twist(message.twist.twist),
    "nav_msgs/Odometry": _odometry,
    "sensor_msgs/Imu": _imu,
    "sensor_msgs/LaserScan": _scan,
    "sensor_msgs/NavSatFix": _fix,
    "std_msgs/Bool": lambda message: "yes" if message.data else "no",
}
