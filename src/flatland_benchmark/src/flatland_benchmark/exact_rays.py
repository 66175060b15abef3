"""Ray casting by brute force in double precision: the reference where two ray casters differ."""

from typing import Sequence, Tuple

import numpy as np

from flatland_server.arrays import FloatArray, Segments

_AT_ENDS = 1e-9
"""Tolerance [m] past a segment's ends, so that adjacent segments leave no gap."""

_AT_ONCE = 4_000_000
"""Pairs of a ray and a segment per batch; each needs 100 bytes of memory."""


def distances_to_segments(
    origins: FloatArray, directions: FloatArray, segments: Segments
) -> FloatArray:
    """Distance along each ray to the first segment; infinity if there is none.

    A ray parallel to a segment does not meet it.

    Args:
        origins: shape (n, 2).
        directions: unit vectors, shape (n, 2).
        segments: shape (m, 4), x1, y1, x2, y2.

    Returns:
        Shape (n,), in the segments' unit.
    """
    result = np.full(len(origins), np.inf)
    if len(segments) == 0:
        return result
    rays = max(1, _AT_ONCE // len(segments))
    for begin in range(0, len(origins), rays):
        part = slice(begin, begin + rays)
        result[part] = _distances(origins[part], directions[part], segments).min(axis=1)
    return result


def _distances(origins: FloatArray, directions: FloatArray, segments: Segments) -> FloatArray:
    """Distances from each ray to each segment: shape (n, m).

    The point o + t d of the ray is the point a + u e of the segment, where
    t = (a - o) x e / (d x e) and u = (a - o) x d / (d x e).
    """
    dx, dy = directions[:, 0, None], directions[:, 1, None]
    ex, ey = segments[:, 2] - segments[:, 0], segments[:, 3] - segments[:, 1]
    ax, ay = segments[:, 0] - origins[:, 0, None], segments[:, 1] - origins[:, 1, None]
    slack = _AT_ENDS / np.hypot(ex, ey)
    with np.errstate(divide="ignore", invalid="ignore"):
        per_unit = 1.0 / (dx * ey - dy * ex)
        t = (ax * ey - ay * ex) * per_unit
        u = (ax * dy - ay * dx) * per_unit
        is_met = (t >= 0.0) & (u >= -slack) & (u <= 1.0 + slack) & np.isfinite(per_unit)
    return np.where(is_met, t, np.inf)


def distances_to_circle(
    origins: FloatArray, directions: FloatArray, center: Tuple[float, float], radius: float
) -> FloatArray:
    """Distance along each ray to a circle; infinity from inside it."""
    from_center = origins - np.array(center)
    # |o - c + t d| = r is t^2 + 2 b t + c = 0; the ray enters at the lesser t.
    b = np.sum(from_center * directions, axis=1)
    c = np.sum(from_center**2, axis=1) - radius**2
    discriminant = b**2 - c
    t = -b - np.sqrt(np.maximum(discriminant, 0.0))
    return np.where((c > 0.0) & (discriminant >= 0.0) & (t >= 0.0), t, np.inf)


def distances_to_polygon(
    origins: FloatArray, directions: FloatArray, vertices: Sequence[Tuple[float, float]]
) -> FloatArray:
    """Distance along each ray to a convex polygon; infinity from inside it.

    Args:
        origins: shape (n, 2).
        directions: unit vectors, shape (n, 2).
        vertices: counter-clockwise.
    """
    corners = np.array(vertices)
    edges = np.roll(corners, -1, axis=0) - corners
    to_origins = origins[:, None] - corners
    left = edges[:, 0] * to_origins[..., 1] - edges[:, 1] * to_origins[..., 0] > 0.0
    segments = np.hstack([corners, corners + edges])
    return np.where(left.all(axis=1), np.inf, distances_to_segments(origins, directions, segments))
