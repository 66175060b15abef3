"""/map: the first layer as nav_msgs/OccupancyGrid, for planners and localisers."""

import logging
import math
from pathlib import Path
from typing import Optional, Tuple

import numpy as np

from flatland_server.arrays import Int8Array, Segments
from flatland_server.exceptions import YamlError
from flatland_server.geometry import Pose
from flatland_server.maps.line_map import ServerMap
from flatland_server.messages.conversions import FRAME_ID, fill_pose, header
from flatland_server.messages.message_types import get
from flatland_server.models.layer import Layer, LayerConfig
from flatland_server.simulation.world import World
from flatland_server.transport.transport import Transport

OccupancyGrid = get("nav_msgs/OccupancyGrid")

logger = logging.getLogger(__name__)

_RESOLUTION = 0.05
"""Of a map that is drawn [m]; coarser if it had more than `_MOST_CELLS`."""
_MARGIN = 20
"""Free cells around it."""
_MOST_CELLS = 16_000_000


class OccupancyMap:
    """Publishes /map, latched, and again when another world is opened.

    An image layer is what map_server makes of its file. Other layers are drawn: cells with a wall
    are occupied, all others are free.
    """

    def __init__(self, world: World, transport: Transport) -> None:
        self._world = world
        self._publisher = transport.advertise("map", OccupancyGrid, latch=True, queue_size=1)
        self._shown: Optional[LayerConfig] = None
        self.update()

    def update(self) -> None:
        """Publishes if there is another map; to be called often."""
        layers = [each for each in self._world.layers if len(each.segments)]
        if layers and layers[0].config is not self._shown:
            self._shown = layers[0].config
            self._publish(*_cells_of(layers[0]))

    def _publish(self, cells: Int8Array, resolution: float, origin: Pose) -> None:
        message = OccupancyGrid(header=header(0, FRAME_ID))
        message.info.resolution = resolution
        message.info.height, message.info.width = cells.shape
        fill_pose(message.info.origin, origin)
        message.data = cells.ravel()
        self._publisher.publish(message)


def _cells_of(layer: Layer) -> Tuple[Int8Array, float, Pose]:
    """The cells of a map, the lowest row first, their size [m], and the pose of the corner."""
    config = layer.config
    if isinstance(config.map, Path) and config.encloses:
        try:
            image = ServerMap.from_file(config.map)
            return image.cells, image.resolution, image.origin
        except YamlError as error:
            logger.warning("/map is drawn, since map_server would not read the layer: %s", error)
    return draw(layer.segments)


def draw(walls: Segments) -> Tuple[Int8Array, float, Pose]:
    """Draws walls into a grid.

    Args:
        walls: [m]: shape (n, 4), x1, y1, x2, y2.

    Returns:
        The cells, 0 or 100, the lowest row first: shape (height, width). Their size [m]. The pose
        of the first corner.
    """
    ends = walls.reshape(-1, 2)
    area = float(np.prod(np.ptp(ends, axis=0) + 2 * _MARGIN * _RESOLUTION))
    resolution = max(_RESOLUTION, math.sqrt(area / _MOST_CELLS))
    first = np.floor(ends.min(axis=0) / resolution) - _MARGIN
    width, height = (np.floor(ends.max(axis=0) / resolution) - first).astype(int) + _MARGIN + 1
    starts, sides = walls[:, :2], walls[:, 2:] - walls[:, :2]
    counts = np.ceil(np.abs(sides).max(axis=1) / resolution * 4).astype(int) + 1
    index = np.repeat(np.arange(len(walls)), counts)
    within = np.arange(len(index)) - np.repeat(np.cumsum(counts) - counts, counts)
    fractions = within / np.maximum(counts - 1, 1)[index]
    points = starts[index] + fractions[:, None] * sides[index]
    columns, rows = (np.floor(points / resolution) - first).astype(int).T
    cells = np.zeros((height, width), np.int8)
    cells[rows, columns] = 100
    x, y = (first * resolution).tolist()
    return cells, resolution, Pose(x, y, 0.0)
