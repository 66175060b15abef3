"""The node flatland_viz: opens rviz on the running world, or says that there is no display."""

import ctypes
import os
import signal
import sys
from pathlib import Path
from typing import List

import rospkg
import rospy
import yaml
from flatland_msgs.msg import DebugTopicList
from visualization_msgs.msg import MarkerArray

from flatland_viz.rviz_config import Bounds, for_world

_SERVER = "flatland_server"


def main() -> int:
    """Replaces this process by rviz; without a display, waits idly to be ended.

    It does not just exit, because the launch ends with this node: closing the window is meant to.
    """
    rospy.init_node("flatland_viz")
    if not _has_display():
        rospy.logwarn("no display: going on without a window (show_viz:=false avoids this line)")
        rospy.spin()
        return 0
    try:
        config = _config()
    except rospy.ROSException:  # the launch ends before the server has told what there is
        return 0
    rospy.signal_shutdown("rviz takes over")
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    rviz = ["rviz", "-d", config, *(arg for arg in sys.argv[1:] if ":=" in arg)]
    os.execvp("rviz", rviz)


def _has_display() -> bool:
    """Whether the X server that DISPLAY names lets us in."""
    try:
        x11 = ctypes.CDLL("libX11.so.6")
    except OSError:
        return False
    x11.XOpenDisplay.restype = ctypes.c_void_p
    x11.XCloseDisplay.argtypes = [ctypes.c_void_p]
    display = x11.XOpenDisplay(None)
    if display:
        x11.XCloseDisplay(display)
    return bool(display)


def _config() -> str:
    """The path of an rviz configuration for the world, made now."""
    debug = rospy.resolve_name(f"{_SERVER}/debug")
    listed = rospy.wait_for_message(f"{debug}/topics", DebugTopicList)
    scans = [
        topic for topic, kind in rospy.get_published_topics() if kind == "sensor_msgs/LaserScan"
    ]
    layers = [f"{debug}/{topic}" for topic in listed.topics if topic.startswith("layer/")]
    markers = [*layers, f"{debug}/models"]  # all models, also those that are spawned later
    base = Path(rospkg.RosPack().get_path("flatland_viz")) / "rviz" / "flatland.rviz"
    config = for_world(yaml.safe_load(base.read_text()), markers, sorted(scans), _bounds(layers))
    path = Path(rospkg.get_ros_home()) / "flatland_viz.rviz"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(yaml.safe_dump(config, sort_keys=False))
    return str(path)


def _bounds(layer_topics: List[str]) -> Bounds:
    """The box around all walls; 10 x 10 m about the origin if there are none."""
    points = []
    for topic in layer_topics:
        for marker in rospy.wait_for_message(topic, MarkerArray).markers:
            points.extend(marker.points)
    if not points:
        return Bounds(-5.0, -5.0, 5.0, 5.0)
    xs, ys = [point.x for point in points], [point.y for point in points]
    return Bounds(min(xs), min(ys), max(xs), max(ys))
