"""Observations: the lidar's ranges, the goal relative to the robot, and the velocity.

By default one flat array of float32, the input of most networks, and quick to copy. The core's
`GoalObserver` makes it. Its parts are in the order of the dict:

    ranges    range / maximum of the lidar; 1 for no return; (beams,)
    goal      distance / maximum of the lidar, at most 10; cosine and sine of its bearing; (3,)
    velocity  each part / its limit in the actions, within [-2, 2]; forwards, to the left (not with
              DiffDrive and TricycleDrive), turning
"""

from typing import Any, Dict, Tuple

import numpy as np

from flatland_server import Float32Array, FloatArray

FARTHEST = 10.0
FASTEST = 2.0


def bounds(beams: int, parts: int) -> Tuple[Float32Array, Float32Array]:
    """The least and the largest values of flat observations.

    Args:
        beams: of the lidar.
        parts: of the velocity.
    """
    low = [0.0] * beams + [0.0, -1.0, -1.0] + [-FASTEST] * parts
    high = [1.0] * beams + [FARTHEST, 1.0, 1.0] + [FASTEST] * parts
    return np.array(low, np.float32), np.array(high, np.float32)


def goal_distances(poses: FloatArray, goals: FloatArray) -> FloatArray:
    """The distances of robots from their goals [m]; shape (n,)."""
    distances: FloatArray = np.hypot(goals[:, 0] - poses[:, 0], goals[:, 1] - poses[:, 1])
    return distances


def as_dict(observation: Float32Array, beams: int) -> Dict[str, Any]:
    """The parts of flat observations, as copies; along the last axis."""
    return {
        "ranges": observation[..., :beams].copy(),
        "goal": observation[..., beams : beams + 3].copy(),
        "velocity": observation[..., beams + 3 :].copy(),
    }
