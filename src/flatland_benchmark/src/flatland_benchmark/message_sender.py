"""Topics of robots that a compiled program sends to: the limit of a server with subscribers.

    python3 -m flatland_benchmark.message_sender ROBOTS STEPS

Advertises the topics of this many robots, waits until all of them have a subscriber, and hands the
sockets to `flatland_message_sender`, which sends messages of the sizes of the server's as fast as
they are taken: those of STEPS steps of a topic in one call.
"""

import os
import struct
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, List, NamedTuple

import rospy
from flatland_msgs.msg import SimulationState
from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage

from flatland_benchmark.server_process import ServerProcess, executable
from flatland_server.messages.wire_form import serialized
from flatland_server.ros.rospy_patches import tcpros_server

_STEPS_PER_SCAN = 20
_BEAMS = 1081


class _Topic(NamedTuple):
    """A topic, the number of steps between its messages (0: in real time), and its message."""

    name: str
    every: int
    message: Any


def main(robots: int, steps: int) -> None:
    """Never returns."""
    rospy.init_node("flatland_server", disable_rostime=True)
    tcpros_server.install()  # of 200 connections at once, rospy's server loses some now and then
    topics = [_Topic("/flatland_server/state", 0, SimulationState()), _Topic("/tf", 1, TFMessage())]
    for i in range(robots):
        base, odom = f"robot_{i}_base_link", "odom"
        odometry = Odometry(child_frame_id=base)
        odometry.header.frame_id = odom
        scan = LaserScan(ranges=[1.0] * _BEAMS)
        scan.header.frame_id = f"robot_{i}_laser"
        topics.append(_Topic(f"/robot_{i}/odometry/filtered", 1, odometry))
        topics.append(_Topic(f"/robot_{i}/scan", _STEPS_PER_SCAN, scan))
        for frame in (base, f"robot_{i}_left_wheel", f"robot_{i}_right_wheel"):
            transform = TransformStamped(child_frame_id=frame)
            transform.header.frame_id = base if frame != base else odom
            topics[1].message.transforms.append(transform)
    publishers = [
        rospy.Publisher(name, type(message), queue_size=100, tcp_nodelay=True)
        for name, _, message in topics
    ]
    # The state goes to the observer of a benchmark, too.
    while not all(
        publisher.get_num_connections() >= (1 if topic.every else 2)
        for publisher, topic in zip(publishers, topics)
    ):
        publishers[0].publish(topics[0].message)
        time.sleep(0.2)
    _send(topics, publishers, steps)


def _send(topics: List[_Topic], publishers: List[Any], steps: int) -> None:
    """Replaces this process by the compiled sender, which inherits the sockets."""
    folder = Path(tempfile.mkdtemp(dir=os.environ.get("ROS_HOME")))  # which the benchmark removes
    lines = []
    for i, ((_, every, message), publisher) in enumerate(zip(topics, publishers)):
        data = serialized(message)
        file = folder / str(i)
        file.write_bytes(struct.pack("<I", len(data)) + data)
        for connection in publisher.impl.connections:
            os.set_inheritable(connection.fileno(), True)
            lines.append(f"{connection.fileno()} {every} {file}\n")
    (folder / "sockets").write_text("".join(lines))
    with (folder / "sockets").open() as sockets:
        os.dup2(sockets.fileno(), 0)
    program = executable("flatland_benchmark", "flatland_message_sender")
    os.execv(program, [program, str(ServerProcess.STEP_SIZE), str(steps)])


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
