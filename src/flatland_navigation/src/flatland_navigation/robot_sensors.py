"""A robot's pose and laser scan, from its topics."""

from dataclasses import dataclass
from typing import Any, Optional, Tuple

import rospy
import tf2_ros
from sensor_msgs.msg import LaserScan

from flatland_navigation.messages import is_upside_down, to_pose, transform_to_pose
from flatland_navigation.obstacles import scan_points
from flatland_server import FloatArray, Pose

_TF_ERRORS = (
    tf2_ros.LookupException,
    tf2_ros.ConnectivityException,
    tf2_ros.ExtrapolationException,
)


class Localization:
    """The robot's pose on the map, from an odometry message.

    Args:
        source: "ground_truth", the topic odometry/ground_truth; or "tf", the topic of odometry
            and the newest transform from the map to its frame.
        map_frame: the frame of the map.
        odom_topic: the topic of odometry.
    """

    def __init__(self, source: str, map_frame: str, odom_topic: str) -> None:
        self._map_frame = map_frame
        self._tf: Optional[Transforms] = Transforms() if source == "tf" else None
        self.topic = odom_topic if source == "tf" else "odometry/ground_truth"
        """The topic of the odometry."""

    def pose(self, message: Any) -> Optional[Pose]:
        """The pose of a nav_msgs/Odometry; None while its transform is not known."""
        pose = to_pose(message.pose.pose)
        if self._tf is None:
            return pose
        transform = self._tf.find(self._map_frame, message.header.frame_id)
        if transform is None:
            rospy.logwarn_throttle(
                10.0, f"waiting for the transform {self._map_frame} -> {message.header.frame_id}"
            )
            return None
        return transform_to_pose(transform).compose(pose)


@dataclass(frozen=True)
class Scan:
    """A scan, and how its laser is mounted on the robot."""

    message: Any
    mount: Pose
    is_upside_down: bool

    @property
    def time(self) -> float:
        """The time of the scan [s]."""
        return float(self.message.header.stamp.to_sec())

    def points_from(self, pose: Pose) -> FloatArray:
        """The points hit by the beams, for a robot at a pose: shape (n, 2) [m]."""
        scan = self.message
        return scan_points(
            scan.ranges,
            scan.angle_min,
            scan.angle_increment,
            scan.range_max,
            pose.compose(self.mount),
            -1.0 if self.is_upside_down else 1.0,
        )


class ScanReader:
    """Keeps the newest scan of a topic. Transforms are received until the laser's is known."""

    def __init__(self, topic: str) -> None:
        self._newest: Any = None
        self._tf: Optional[Transforms] = None
        self._mount: Optional[Tuple[Pose, bool]] = None
        self._subscriber = rospy.Subscriber(
            topic, LaserScan, self._on_scan, queue_size=1, buff_size=2**20, tcp_nodelay=True
        )

    @property
    def topic(self) -> str:
        """The name of the topic, with remappings."""
        return str(self._subscriber.resolved_name)

    @property
    def has_laser(self) -> bool:
        """True if the topic has a publisher."""
        return bool(self._subscriber.get_num_connections())

    @property
    def is_awaited(self) -> bool:
        """True if the robot has a laser, but no scan could be read yet."""
        return self._mount is None and self.has_laser

    def take(self, base_frame: str) -> Optional[Scan]:
        """The newest scan, if it was not taken yet and the laser's transform is known."""
        message, self._newest = self._newest, None
        if message is None:
            return None
        if self._mount is None:
            self._mount = self._find_mount(base_frame, message.header.frame_id)
        return Scan(message, *self._mount) if self._mount is not None else None

    def _on_scan(self, message: LaserScan) -> None:
        self._newest = message

    def _find_mount(self, base_frame: str, laser_frame: str) -> Optional[Tuple[Pose, bool]]:
        if self._tf is None:
            self._tf = Transforms()
        transform = self._tf.find(base_frame, laser_frame)
        if transform is None:
            return None
        self._tf.close()
        return transform_to_pose(transform), is_upside_down(transform)


class Transforms:
    """The newest transforms of /tf and /tf_static."""

    def __init__(self) -> None:
        self._buffer = tf2_ros.Buffer()
        self._listener = tf2_ros.TransformListener(self._buffer)

    def find(self, parent: str, child: str, time: Any = rospy.Time()) -> Any:  # noqa: B008
        """A geometry_msgs/Transform from a frame to another, or None; by default the newest one."""
        try:
            return self._buffer.lookup_transform(parent, child, time).transform
        except _TF_ERRORS:
            return None

    def close(self) -> None:
        """Unsubscribes."""
        self._listener.unregister()
