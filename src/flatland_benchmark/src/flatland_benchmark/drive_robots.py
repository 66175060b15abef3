"""Has robots drive in circles: python3 -m flatland_benchmark.drive_robots NAMESPACE..."""

import sys
import time

import rospy
from geometry_msgs.msg import Twist

_LIMIT = 30.0  # s


def main() -> int:
    """Commands the robots once; a drive keeps its last command."""
    rospy.init_node("drive_robots", disable_rostime=True)
    publishers = [
        rospy.Publisher(f"/{name}/cmd_vel", Twist, queue_size=1, latch=True)
        for name in sys.argv[1:]
    ]
    command = Twist()
    command.linear.x, command.angular.z = 0.1, 0.5
    for publisher in publishers:
        publisher.publish(command)
    deadline = time.monotonic() + _LIMIT
    while not all(publisher.get_num_connections() for publisher in publishers):
        if time.monotonic() > deadline:
            return 1
        time.sleep(0.05)
    time.sleep(1.0)  # rospy sends on threads of its own, without a notice of completion
    return 0


if __name__ == "__main__":
    sys.exit(main())
