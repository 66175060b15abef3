"""The free pixels of a map image, and random poses in them."""

from pathlib import Path
from typing import List, NamedTuple, Optional, Tuple

import numpy as np
import yaml
from PIL import Image

from flatland_server import _core
from flatland_server.arrays import BoolArray, FloatArray
from flatland_server.geometry import Pose
from flatland_server.maps import bright_pixels


class FreeSpace(NamedTuple):
    """The free pixels of a map."""

    free: BoolArray
    """True where a pixel is free, the bottom row first."""

    resolution: float
    """Side of a pixel [m]."""

    origin: FloatArray
    """The bottom left corner [m]."""


def read_free_space(map_file: Path) -> FreeSpace:
    """Reads a map with an origin that is not rotated."""
    layer = yaml.safe_load(map_file.read_text())
    with Image.open(map_file.parent / layer["image"]) as image:
        free = bright_pixels(image, layer["occupied_thresh"])[::-1]
    return FreeSpace(free, layer["resolution"], np.array(layer["origin"][:2], np.float64))


def free_poses(
    map_file: Path, count: int, seed: int, reachable_from: Optional[Tuple[float, float]] = None
) -> List[Pose]:
    """Poses uniformly distributed over the free pixels of a map, with any heading.

    Args:
        map_file: of an image map with an origin that is not rotated.
        count: number of poses.
        seed: the seed of the poses.
        reachable_from: only pixels connected with this point [m]; by default all free pixels,
            outside the walls, too.
    """
    rng = np.random.default_rng(seed)
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
    """Poses, shape (n, 3), rounded, so that all ray casters start at the same point."""
    rounded: List[List[float]] = poses.astype(np.float32).tolist()
    return [Pose(*each) for each in rounded]
