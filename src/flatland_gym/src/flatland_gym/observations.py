"""Observations: the lidar's ranges, the goal relative to the robot, and the velocity.

By default one flat array of float32, the input of most networks, and quick to copy. Its parts are
in the order of the dict:

    ranges    range / maximum of the lidar; 1 for no return; (beams,)
    goal      distance / maximum of the lidar, at most 10; cosine and sine of its bearing; (3,)
    velocity  each part / its limit in the actions, within [-2, 2]; forwards, to the left (not with
              DiffDrive and TricycleDrive), turning
"""

from typing import Any, Dict, Tuple

import numpy as np

from flatland_server import Float32Array, FloatArray, cos_sin

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


def observe(
    ranges: Float32Array,
    poses: FloatArray,
    velocities: FloatArray,
    goals: FloatArray,
    max_range: float,
    velocity_limits: FloatArray,
) -> Float32Array:
    """Flat observations: a new array of float32, shape (n, beams + 3 + parts of the velocity).

    A row does not depend on the other rows.

    Args:
        ranges: [m], shape (n, beams).
        poses: shape (n, 3).
        velocities: in the robots' frames, shape (n, 3): forwards, to the left, turning.
        goals: shape (n, 2).
        max_range: of the lidar [m].
        velocity_limits: by which velocities are divided, shape (3,); 0 leaves the part out.
    """
    beams, used = ranges.shape[1], np.flatnonzero(velocity_limits)
    result = np.empty((len(ranges), beams + 3 + len(used)), np.float32)
    scaled = ranges / np.float32(max_range)  # contiguous: quicker than in the rows of the result
    result[:, :beams] = np.minimum(scaled, np.float32(1.0), out=scaled)
    x, y = goals[:, 0] - poses[:, 0], goals[:, 1] - poses[:, 1]
    cosine, sine = cos_sin(poses[:, 2])
    distance = np.hypot(x, y)
    safe = np.where(distance > 0.0, distance, 1.0)
    result[:, beams] = np.minimum(distance / max_range, FARTHEST)
    result[:, beams + 1] = np.where(distance > 0.0, (cosine * x + sine * y) / safe, 1.0)
    result[:, beams + 2] = (cosine * y - sine * x) / safe
    parts = velocities[:, used] / velocity_limits[used]
    result[:, beams + 3 :] = np.clip(parts, -FASTEST, FASTEST)
    result[:, beams + 1 : beams + 3] = np.clip(result[:, beams + 1 : beams + 3], -1.0, 1.0)
    return result


def as_dict(observation: Float32Array, beams: int) -> Dict[str, Any]:
    """The parts of flat observations, as copies; along the last axis."""
    return {
        "ranges": observation[..., :beams].copy(),
        "goal": observation[..., beams : beams + 3].copy(),
        "velocity": observation[..., beams + 3 :].copy(),
    }
