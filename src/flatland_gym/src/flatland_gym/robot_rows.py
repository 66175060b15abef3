"""Measurements of n robots, as arrays with a row for each."""

from flatland2d import BatchObservation
from flatland_server import BoolArray, Float32Array, FloatArray


class RobotRows:
    """The state of n robots, as arrays that are overwritten in each step.

    Args:
        arrays: to write to.

    Attributes:
        arrays: all arrays below.
        ranges: [m], +inf for no return; float32, shape (n, beams).
        poses: x, y [m] and yaw [rad] in the world, shape (n, 3).
        velocities: in the robots' frames, shape (n, 3): forwards, to the left, turning.
        collided: whether a robot has touched something solid in its last step, shape (n,).
    """

    def __init__(self, arrays: BatchObservation) -> None:
        self.arrays = arrays
        self.ranges: Float32Array = arrays.ranges
        self.poses: FloatArray = arrays.poses
        self.velocities: FloatArray = arrays.local_velocities
        self.collided: BoolArray = arrays.collided
