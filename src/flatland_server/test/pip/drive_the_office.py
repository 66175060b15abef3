"""Drives the office's robot for ten seconds, into walls and boxes; prints a digest of it as JSON.

Run by a Python that has the library: by pip, or by catkin.
"""

import hashlib
import json
import sys

import numpy as np

from flatland2d import LocalTransport, Timekeeper, World
from flatland_server.config.shipped_worlds import find_world


class Twist:
    """As a geometry_msgs/Twist."""

    class Vector:
        """As a geometry_msgs/Vector3."""

        def __init__(self, x=0.0, z=0.0):
            self.x, self.y, self.z = x, 0.0, z

    def __init__(self, linear, angular):
        self.linear, self.angular = self.Vector(x=linear), self.Vector(z=angular)


transport = LocalTransport()
world = World.from_file(find_world("office"), transport, seed=1)
time = Timekeeper(0.005)
digest = hashlib.sha256()
for step in range(2000):
    transport.send("/cmd_vel", Twist(1.5, 0.3 if step % 400 < 200 else -0.5))
    transport.process()
    world.step(time)
    poses = [(m.pose.x, m.pose.y, m.pose.yaw) for m in world.models.values()]
    digest.update(np.array(poses).tobytes())
    scan = transport.last("/scan")
    if scan is not None:
        digest.update(np.asarray(scan.ranges, np.float32).tobytes())
        pose = transport.last("/odometry/filtered").pose.pose
        numbers = [pose.position.x, pose.position.y, pose.orientation.z, pose.orientation.w]
        digest.update(np.array(numbers).tobytes())

core = sys.modules["flatland_server._core"].__file__
print(
    json.dumps(
        {"digest": digest.hexdigest(), "robot": poses[0], "ranges": len(scan.ranges), "core": core}
    )
)
