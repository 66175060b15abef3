"""Observations: the lidar's ranges, the goal relative to the robot, and the velocity.

By default one flat array of float32, the input of most networks, and quick to copy. The core's
`GoalObserver` makes it. Its parts are in the order of the dict:

    ranges    range / maximum of the lidar; 1 for no return; (beams,)
    goal      distance / maximum of the lidar, at most 10; cosine and sine of its bearing; (3,)
    velocity  each part / its limit in the actions, within [-2, 2]; forwards, to the left (not with
              DiffDrive and what is steered), turning
    neighbors with `neighbors=k`, the k nearest other models, see `neighbor_rows`; (k, 6)
"""

from typing import Any, Dict, Sequence, Tuple

import numpy as np

from flatland_server import Float32Array, FloatArray

STANDARD = ("ranges", "goal", "velocity", "neighbors")
"""The parts, in their order."""

FARTHEST = 10.0
FASTEST = 2.0
NEIGHBOR = 6
"""Numbers of a neighbour."""
_FASTEST_NEIGHBOR = 5.0  # m/s


def bounds(beams: int, parts: int, neighbors: int = 0) -> Tuple[Float32Array, Float32Array]:
    """The least and the largest values of flat observations.

    Args:
        beams: number of the lidar's beams.
        parts: number of the velocity's parts.
        neighbors: number of neighbours in an observation.
    """
    fastest = _FASTEST_NEIGHBOR
    low = [0.0] * beams + [0.0, -1.0, -1.0] + [-FASTEST] * parts
    high = [1.0] * beams + [FARTHEST, 1.0, 1.0] + [FASTEST] * parts
    low += [0.0, -1.0, -1.0, -fastest, -fastest, 0.0] * neighbors
    high += [1.0, 1.0, 1.0, fastest, fastest, 1.0] * neighbors
    return np.array(low, np.float32), np.array(high, np.float32)


def mirror_signs(beams: int, velocity_limits: Sequence[float], neighbors: int = 0) -> Float32Array:
    """1, or -1 where a number changes its sign if left and right change places.

    Args:
        beams: number of the lidar's beams.
        velocity_limits: of forwards, to the left and turning; 0 for no such part.
        neighbors: number of neighbours in an observation.
    """
    velocity = [sign for sign, limit in zip((1.0, -1.0, -1.0), velocity_limits) if limit > 0.0]
    signs = [1.0] * beams + [1.0, 1.0, -1.0] + velocity
    signs += [1.0, 1.0, -1.0, 1.0, -1.0, 1.0] * neighbors
    return np.array(signs, np.float32)


def goal_distances(poses: FloatArray, goals: FloatArray) -> FloatArray:
    """The distances of robots from their goals [m]; shape (n,)."""
    distances: FloatArray = np.hypot(goals[:, 0] - poses[:, 0], goals[:, 1] - poses[:, 1])
    return distances


def neighbor_rows(
    poses: FloatArray, velocities: FloatArray, others: FloatArray, count: int, reach: float
) -> Float32Array:
    """The nearest other models of n robots, the nearest first; shape (n, 6 * count).

    Six numbers for each: 1 / (1 + gap); cosine and sine of its bearing; its velocity relative to
    the robot's, forwards and to the left in the robot's frame [m/s]; and 1 / (1 + time), with the
    time until they touch if both keep their velocities: 1 if they do, 0 if they will not. Such a
    time is an observation in Han et al., "Reinforcement learned distributed multi-robot navigation
    with reciprocal velocity obstacle shaped rewards", IEEE RA-L 7(3), 2022. All are zero where
    there is no model within reach.

    Args:
        poses: of the robots, shape (n, 3).
        velocities: of the robots, forwards, to the left and turning, shape (n, 3).
        others: shape (n, m, 5): x, y [m], vx, vy [m/s] in the world, and the radius of both
            together [m]; NaN for none.
        count: number of neighbours.
        reach: the largest gap [m].
    """
    offsets = others[..., :2] - poses[:, None, :2]
    gaps = np.hypot(offsets[..., 0], offsets[..., 1]) - others[..., 4]
    gaps = np.where(gaps <= reach, gaps, np.inf)  # also for NaN
    nearest = np.argsort(gaps, axis=1, kind="stable")[:, :count, None]
    others = np.take_along_axis(others, nearest, 1)
    turn = np.exp(-1j * poses[:, 2])[:, None]
    offset = (np.take_along_axis(offsets, nearest, 1) @ _COMPLEX) * turn
    velocity = (others[..., 2:4] @ _COMPLEX) * turn - (velocities[:, :2] @ _COMPLEX)[:, None]
    distance, radius = np.abs(offset), others[..., 4]
    with np.errstate(divide="ignore", invalid="ignore"):  # a bearing at the same place, no model
        bearing = offset / distance
        closing = -(offset * velocity.conj()).real
        square = np.abs(velocity) ** 2
        room = np.maximum(distance**2 - radius**2, 0.0)
        time = room / (closing + np.sqrt(closing**2 - square * room))
        time = np.where(room > 0.0, np.where(closing > 0.0, time, np.inf), 0.0)
        parts = (
            1.0 / (1.0 + np.maximum(distance - radius, 0.0)),
            *(bearing.real, bearing.imag),
            *(np.clip(part, -_FASTEST_NEIGHBOR, _FASTEST_NEIGHBOR) for part in _parts(velocity)),
            1.0 / (1.0 + np.where(np.isnan(time), np.inf, time)),
        )
    found = np.stack(parts, axis=-1)
    is_near = np.isfinite(np.take_along_axis(gaps, nearest[..., 0], 1))[..., None]
    rows = np.zeros((len(poses), count, NEIGHBOR), np.float32)
    rows[:, : found.shape[1]] = np.where(is_near, np.nan_to_num(found), 0.0)
    return rows.reshape(len(poses), -1)


_COMPLEX = np.array([1.0, 1.0j])


def _parts(numbers: Any) -> Tuple[FloatArray, FloatArray]:
    return numbers.real, numbers.imag


def as_dict(observation: Float32Array, beams: int, neighbors: int = 0) -> Dict[str, Any]:
    """The parts of flat observations, as copies; along the last axis."""
    end = observation.shape[-1] - NEIGHBOR * neighbors
    parts = {
        "ranges": observation[..., :beams].copy(),
        "goal": observation[..., beams : beams + 3].copy(),
        "velocity": observation[..., beams + 3 : end].copy(),
    }
    if neighbors:
        shape = (*observation.shape[:-1], neighbors, NEIGHBOR)
        parts["neighbors"] = observation[..., end:].reshape(shape).copy()
    return parts
