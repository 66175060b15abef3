"""Random poses in the free space of a map's image."""

from pathlib import Path
from typing import List, Optional, Tuple

import numpy as np

from flatland_benchmark.free_space import read_free_space
from flatland_server import _core
from flatland_server.arrays import FloatArray
from flatland_server.geometry import Pose


def free_poses(
    map_file: Path,
    count: int,
    rng: np.random.Generator,
    reachable_from: Optional[Tuple[float, float]] = None,
) -> List[Pose]:
    """Poses uniformly distributed over the free pixels of a map, with any heading.

    They are rounded to single precision, so that all ray casters start at the same point.

    Args:
        map_file: of an image map with an origin that is not rotated.
        count: number of poses.
        rng: the random generator.
        reachable_from: only pixels connected with this point [m]; by default all free pixels,
            outside the walls, too.
    """
    free, resolution, origin = read_free_space(map_file)
    if reachable_from is not None:
        column, row = ((np.array(reachable_from) - origin) / resolution).astype(int)
        free = _core.connected(free, (row, column))
    rows, columns = np.nonzero(free)
    chosen = rng.integers(len(rows), size=count)
    pixels = np.stack([columns[chosen], rows[chosen]], axis=1)
    points = (pixels + rng.uniform(0.01, 0.99, (count, 2))) * resolution + origin
    yaws = rng.uniform(-np.pi, np.pi, count)
    return single_precision(np.column_stack([points, yaws]))


def single_precision(poses: FloatArray) -> List[Pose]:
    """Poses, shape (n, 3), rounded to single precision."""
    rounded: List[List[float]] = poses.astype(np.float32).tolist()
    return [Pose(*each) for each in rounded]
