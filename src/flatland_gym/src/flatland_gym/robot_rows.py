"""What is measured of n robots, as arrays with a row for each."""

import numpy as np

from flatland_server import BoolArray, Float32Array, FloatArray


class RobotRows:
    """The state of n robots, as arrays that are overwritten in each step.

    Attributes:
        ranges: [m], +inf for no return; float32, shape (n, beams).
        poses: x, y [m] and yaw [rad] in the world, shape (n, 3).
        velocities: in the robots' frames, shape (n, 3): forwards, to the left, turning.
        collided: whether a robot has touched something solid in its last step, shape (n,).
    """

    def __init__(self, count: int, beams: int) -> None:
        self.ranges: Float32Array = np.zeros((count, beams), np.float32)
        self.poses: FloatArray = np.zeros((count, 3))
        self.velocities: FloatArray = np.zeros((count, 3))
        self.collided: BoolArray = np.zeros(count, dtype=bool)
