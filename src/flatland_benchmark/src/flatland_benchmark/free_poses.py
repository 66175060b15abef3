"""Random poses in the free space of a map's image."""

from pathlib import Path
from typing import List, Optional, Tuple

import numpy as np

from flatland_benchmark.free_space import reachable, read_free_space
from flatland_server.arrays import FloatArray
from flatland_server.geometry import Pose


def free_poses(
    map_file: Path,
    count: int,
    rng: np.random.Generator,
    reachable_from: Optional[Tuple[float, float]] = None,
) -> List[Pose]:
    """Poses evenly spread over the free pixels of a map, anywhere in them, looking anywhere.

    Their numbers fit into single precision, so that all ray casters begin at the same point.

    Args:
        map_file: of an image, without a turned origin.
        count: how many.
        rng: what draws them.
        reachable_from: a point [m] that they are connected with; by default all free pixels count,
            those outside the walls too.
    """
    free, resolution, origin = read_free_space(map_file)
    if reachable_from is not None:
        column, row = ((np.array(reachable_from) - origin) / resolution).astype(int)
        free = reachable(free, row, column)
    rows, columns = np.nonzero(free)
    chosen = rng.integers(len(rows), size=count)
    pixels = np.stack([columns[chosen], rows[chosen]], axis=1)
    points = (pixels + rng.uniform(0.01, 0.99, (count, 2))) * resolution + origin
    yaws = rng.uniform(-np.pi, np.pi, count)
    return single_precision(np.column_stack([points, yaws]))


def single_precision(poses: FloatArray) -> List[Pose]:
    """Poses, shape (n, 3), rounded so that their numbers fit into single precision."""
    rounded: List[List[float]] = poses.astype(np.float32).tolist()
    return [Pose(*each) for each in rounded]
