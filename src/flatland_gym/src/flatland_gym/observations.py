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
_ONE, _MINUS_ONE = np.float32(1.0), np.float32(-1.0)


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
    # Minimum and maximum are quicker than clip, and sums than where.
    beams = ranges.shape[1]
    used = [part for part, limit in enumerate(velocity_limits.tolist()) if limit]
    result = np.empty((len(ranges), beams + 3 + len(used)), np.float32)
    scaled = ranges / np.float32(max_range)  # contiguous: quicker than in the rows of the result
    result[:, :beams] = np.minimum(scaled, np.float32(1.0), out=scaled)
    x, y = goals[:, 0] - poses[:, 0], goals[:, 1] - poses[:, 1]
    cosine, sine = cos_sin(poses[:, 2])
    distance = np.hypot(x, y)
    at_goal = distance == 0.0
    safe = distance + at_goal
    result[:, beams] = np.minimum(distance / max_range, FARTHEST)
    result[:, beams + 1] = (cosine * x + sine * y) / safe + at_goal
    result[:, beams + 2] = (cosine * y - sine * x) / safe
    direction = result[:, beams + 1 : beams + 3]
    np.minimum(np.maximum(direction, _MINUS_ONE, out=direction), _ONE, out=direction)
    parts = velocities / (velocity_limits + (velocity_limits == 0.0))
    np.minimum(np.maximum(parts, -FASTEST, out=parts), FASTEST, out=parts)
    for column, part in enumerate(used, beams + 3):
        result[:, column] = parts[:, part]
    return result


def as_dict(observation: Float32Array, beams: int) -> Dict[str, Any]:
    """The parts of flat observations, as copies; along the last axis."""
    return {
        "ranges": observation[..., :beams].copy(),
        "goal": observation[..., beams : beams + 3].copy(),
        "velocity": observation[..., beams + 3 :].copy(),
    }
