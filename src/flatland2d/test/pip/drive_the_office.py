"""Drives the office's robot for ten seconds, into walls and boxes; prints a digest of it as JSON.

Run by a Python that has the library: by pip, or by catkin.
"""

import hashlib
import json
import sys

import numpy as np

from flatland2d import Simulation

digest = hashlib.sha256()
with Simulation("office", seed=1, topics=["/odometry/filtered"]) as sim:
    robot = sim.models["turtlebot"]
    for turn in range(20):
        robot.command(1.5, 0.3 if turn % 2 else -0.5)
        for _ in range(5):
            sim.step(20)
            scan = robot.sensors["laser"].read()
            pose = sim.last("/odometry/filtered").pose.pose
            odometry = [pose.position.x, pose.position.y, pose.orientation.z, pose.orientation.w]
            for array in (sim.poses, sim.velocities, scan, np.array(odometry)):
                digest.update(array.tobytes())

print(
    json.dumps(
        {
            "digest": digest.hexdigest(),
            "poses": sim.poses.tolist(),
            "beams": len(scan),
            "core": sys.modules["flatland_server._core"].__file__,
        }
    )
)
