"""Wall segments ordered outline by outline.

The shape of Box2D's tree depends on the order in which edges are inserted. Ray casts are up to
twice as slow if consecutive edges are not neighbours.
"""

from collections import defaultdict
from typing import DefaultDict, List

import numpy as np

from flatland_server.arrays import Segments

_SAME = 1e-6
"""Ends closer than this [m] are the same point."""


def trace_outlines(segments: Segments) -> List[Segments]:
    """The same segments as outlines: chains in which each segment begins where the last one ends.

    Outlines come in the order of their first segments, and begin with them. A segment that is
    reached at its second end is reversed.

    Args:
        segments: shape (n, 4), x1, y1, x2, y2.
    """
    points = np.round(segments.reshape(-1, 2) / _SAME)
    numbers = np.unique(points, axis=0, return_inverse=True)[1]
    ends: List[List[int]] = numbers.reshape(-1, 2).tolist()
    at: DefaultDict[int, List[int]] = defaultdict(list)  # the segments at each point, last first
    for index in reversed(range(len(ends))):
        for point in ends[index]:
            at[point].append(index)

    order: List[int] = []
    turned: List[bool] = []
    begins: List[int] = []
    is_left = [True] * len(ends)
    for first in range(len(ends)):
        if is_left[first]:
            begins.append(len(order))
        index, point = first, ends[first][0]
        while is_left[index]:
            is_left[index] = False
            is_turned = ends[index][0] != point
            order.append(index)
            turned.append(is_turned)
            point = ends[index][0 if is_turned else 1]
            here = at[point]
            while here and not is_left[here[-1]]:
                here.pop()
            if here:
                index = here[-1]
    ordered = segments[order]
    ordered[turned] = ordered[turned][:, [2, 3, 0, 1]]
    return np.split(ordered, begins[1:])
