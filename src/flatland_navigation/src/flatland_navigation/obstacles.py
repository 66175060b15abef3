"""Obstacles in a laser scan: their positions, and safe speeds towards them."""

import math
from typing import Union

import numpy as np

from flatland_server import Float32Array, FloatArray, Pose

_SAMPLE = 0.02  # m between positions on an arc


def scan_points(
    ranges: Union[FloatArray, Float32Array],
    angle_min: float,
    increment: float,
    range_max: float,
    sensor: Pose,
    handedness: float = 1.0,
) -> FloatArray:
    """The points that a scan has hit.

    Args:
        ranges: shape (n,) [m]; NaN, infinite ones and those beyond `range_max` hit nothing.
        angle_min: of the first beam, in the sensor's frame [rad].
        increment: between beams [rad].
        range_max: [m].
        sensor: pose of the lidar in the frame of the result.
        handedness: -1 for a sensor that is mounted upside down, otherwise 1.

    Returns:
        Shape (m, 2), m <= n [m].
    """
    distances = np.asarray(ranges, dtype=np.float64)
    hits = np.flatnonzero(distances <= range_max)
    angles = sensor.yaw + handedness * (angle_min + hits * increment)
    x = sensor.x + distances[hits] * np.cos(angles)
    y = sensor.y + distances[hits] * np.sin(angles)
    return np.column_stack([x, y])


def to_frame(points: FloatArray, pose: Pose) -> FloatArray:
    """Transforms points [m], shape (n, 2), from the outer frame into the frame of a pose."""
    cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
    return np.asarray((points - (pose.x, pose.y)) @ np.array([[cos, -sin], [sin, cos]]))


def free_distance(points: FloatArray, curvature: float, radius: float, limit: float) -> float:
    """The distance that a round robot can drive on an arc before it touches a point.

    A point within the radius at the start does not stop a robot that drives away from it.

    Args:
        points: in the robot's frame [m]: shape (n, 2).
        curvature: the arc's curvature [1/m].
        radius: of the robot, with a margin [m].
        limit: length of the arc that is checked [m].

    Returns:
        Between 0 and `limit` [m]; exact to 2 cm, and never too much.
    """
    now = np.hypot(points[:, 0], points[:, 1])
    near = now < limit + radius
    points, now = points[near], now[near]
    if len(points) == 0:
        return limit
    lengths = np.arange(_SAMPLE, limit + _SAMPLE, _SAMPLE)
    turned = lengths * curvature
    if abs(curvature) > 1e-6:
        x, y = np.sin(turned) / curvature, (1.0 - np.cos(turned)) / curvature
    else:
        x, y = lengths, np.zeros_like(lengths)
    distances = np.hypot(
        points[np.newaxis, :, 0] - x[:, np.newaxis], points[np.newaxis, :, 1] - y[:, np.newaxis]
    )
    touched = ((distances < radius) & (distances < now - 1e-9)).any(axis=1)
    if not touched.any():
        return limit
    return float(lengths[touched.argmax()] - _SAMPLE)


def safe_speed(distance: float, deceleration: float, delay: float) -> float:
    """The speed from which a robot stops within a distance: v * delay + v^2 / (2 a) = distance.

    Args:
        distance: [m].
        deceleration: a [m/s^2].
        delay: time until it begins to slow down [s].

    Returns:
        v [m/s].
    """
    reaction = deceleration * delay
    return math.sqrt(reaction * reaction + 2.0 * deceleration * max(distance, 0.0)) - reaction
