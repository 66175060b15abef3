"""Reduces the number of segments of the outlines of a map image, within a tolerance.

The outlines of an image run along the edges of pixels: a wall that is not parallel to an axis is a
staircase. Here the segments are chained into lines, and each line is replaced by one with fewer
corners within a tolerance of it (Ramer, 1972; Douglas and Peucker, 1973).
"""

from collections import defaultdict
from typing import Dict, List, NamedTuple, Tuple

import numpy as np

from flatland_server.arrays import BoolArray, FloatArray, Segments

TOLERANCES = (0.0, 1.0, 2.0)
"""Tolerance of outlines [px], by the level of `simplify_map`: none, moderate, strong."""

Corner = Tuple[float, float]


class Simplified(NamedTuple):
    """Outlines with fewer corners.

    Attributes:
        segments: shape (m, 4); their corners are corners of the given segments.
        deviation: the largest distance between these and the given outlines.
    """

    segments: Segments
    deviation: float


def simplify(segments: Segments, tolerance: float) -> Simplified:
    """Outlines with fewer corners, at most the tolerance away from the given ones.

    Args:
        segments: shape (n, 4), x1, y1, x2, y2; adjacent segments share a corner exactly.
        tolerance: greatest distance of a corner that is left out, in the same unit.

    Returns:
        At most n segments, and how far they are from the given ones.
    """
    pieces = []
    largest = 0.0
    for line in _chains(segments):
        keep, deviation = _essential(line, tolerance)
        largest = max(largest, deviation)
        kept = line[keep]
        if len(kept) == 3 and (kept[0] == kept[2]).all():  # a speck becomes one segment
            kept = kept[:2]
        pieces.append(np.column_stack([kept[:-1], kept[1:]]))
    if not pieces:
        return Simplified(segments, 0.0)
    simplified = np.concatenate(pieces)
    is_segment = (simplified[:, :2] != simplified[:, 2:]).any(axis=1)
    return Simplified(np.asarray(simplified[is_segment]), largest)


def _chains(segments: Segments) -> List[FloatArray]:
    """Chains segments to lines, each of shape (corners, 2).

    A line ends at a corner of one segment, or of three and more; others are closed.
    """
    neighbours: Dict[Corner, List[Corner]] = defaultdict(list)
    for x1, y1, x2, y2 in segments.tolist():
        neighbours[x1, y1].append((x2, y2))
        neighbours[x2, y2].append((x1, y1))

    def follow(start: Corner) -> List[Corner]:
        chain = [start]
        here = start
        while neighbours[here]:
            there = neighbours[here].pop()
            neighbours[there].remove(here)
            chain.append(there)
            here = there
            if here in ends:
                break
        return chain

    ends = {corner for corner, others in neighbours.items() if len(others) != 2}
    chains = []
    for starts in (sorted(ends), sorted(neighbours)):  # first the lines with ends, then the loops
        for start in starts:
            while neighbours[start]:
                chains.append(np.array(follow(start)))
    return chains


def _essential(line: FloatArray, tolerance: float) -> Tuple[BoolArray, float]:
    """The mask of a line's corners to keep, and the largest distance of the others from the result.

    Of a closed line, the corner farthest from the first one is kept. The distance to a segment is
    convex along another, so that it is largest at a corner; and each point of the new line is the
    foot of a perpendicular from a point of the old one. So the largest distance of a corner is
    that of the lines (Hausdorff), or above it where parts of a line come close to each other.

    Returns:
        Shape (corners,), and the largest distance.
    """
    largest = 0.0
    keep = np.zeros(len(line), dtype=bool)
    keep[[0, -1]] = True
    spans = [(0, len(line) - 1)]
    if (line[0] == line[-1]).all():  # closed; must not collapse to a point
        middle = int(np.hypot(*(line - line[0]).T).argmax())
        keep[middle] = True
        spans = [(0, middle), (middle, len(line) - 1)]
    while spans:
        first, last = spans.pop()
        if last - first < 2:
            continue
        between = line[first + 1 : last] - line[first]
        along = line[last] - line[first]
        length = np.hypot(*along)
        if length > 0:
            share = np.clip(between @ along / length**2, 0.0, 1.0)
            distance = np.hypot(*(between - share[:, None] * along).T)
        else:
            distance = np.hypot(*between.T)
        farthest = int(distance.argmax())
        if distance[farthest] > tolerance:
            middle = first + 1 + farthest
            keep[middle] = True
            spans += [(first, middle), (middle, last)]
        else:
            largest = max(largest, float(distance[farthest]))
    return keep, largest
