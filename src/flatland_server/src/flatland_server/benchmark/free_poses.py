"""Random poses in the free space of a map's image."""

from pathlib import Path
from typing import List, Optional, Tuple

import numpy as np
import yaml
from PIL import Image

from flatland_server.arrays import BoolArray
from flatland_server.geometry import Pose
from flatland_server.wall_outlines import bright_pixels


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
    layer = yaml.safe_load(map_file.read_text())
    resolution, origin = layer["resolution"], layer["origin"][:2]
    with Image.open(map_file.parent / layer["image"]) as image:
        free = bright_pixels(image, layer["occupied_thresh"])[::-1]  # the bottom row first
    if reachable_from is not None:
        column, row = ((np.array(reachable_from) - origin) / resolution).astype(int)
        free = reachable(free, row, column)
    rows, columns = np.nonzero(free)
    chosen = rng.integers(len(rows), size=count)
    pixels = np.stack([columns[chosen], rows[chosen]], axis=1)
    points = (pixels + rng.uniform(0.01, 0.99, (count, 2))) * resolution + origin
    yaws = rng.uniform(-np.pi, np.pi, count)
    rounded = np.column_stack([points, yaws]).astype(np.float32).tolist()
    return [Pose(*each) for each in rounded]


def reachable(free: BoolArray, row: int, column: int) -> BoolArray:
    """Which pixels are connected with one of them through free ones, side by side."""
    reached = np.zeros_like(free)
    reached[row, column] = free[row, column]
    before = 0
    while np.count_nonzero(reached) > before:
        before = np.count_nonzero(reached)
        reached = _spread(reached, free)
        reached = _spread(reached.T, free.T).T
    return reached


def _spread(reached: BoolArray, free: BoolArray) -> BoolArray:
    """Along the rows, as far as it is free."""
    breaks = ~free
    breaks[:, 0] = True
    run = np.cumsum(breaks.ravel())  # the free pixels of a run share a number
    is_reached = np.bincount(run, weights=reached.ravel()) > 0
    return np.asarray(is_reached[run].reshape(free.shape) & free)
