"""/map, equal to map_server's: its formula, pixel by pixel, and walls that are drawn."""

import itertools

import numpy as np
import pytest
from PIL import Image

from flatland_server.hub.occupancy_map import OccupancyMap, draw
from flatland_server.maps.line_map import ServerMap
from flatland_server.simulation.world import World
from flatland_server.transport.local_transport import LocalTransport


def cell(channels, mode, negate, occupied, free):
    """A cell as map_server computes it: nav2_map_server's map_io.cpp."""
    has_alpha = len(channels) == 4
    used = channels[:3] if has_alpha and mode == "scale" else channels
    shade = sum(used) / len(used) / 255.0
    occupancy = shade if negate else 1.0 - shade
    if mode == "scale" and has_alpha and channels[3] < 255:
        return -1
    if occupancy > occupied:
        return 100
    if occupancy < free:
        return 0
    return -1 if mode == "trinary" else round((occupancy - free) / (occupied - free) * 100.0)


@pytest.mark.parametrize(
    ("mode", "negate", "kind"),
    itertools.product(["trinary", "scale"], [False, True], ["L", "RGB", "RGBA"]),
)
def test_cells_are_those_of_map_server(tmp_path, mode, negate, kind):
    shape = (7, 9, max(1, len(kind)))
    pixels = np.random.default_rng(5).integers(0, 256, shape, dtype=np.uint8)
    Image.fromarray(pixels.squeeze(), kind).save(tmp_path / "map.png")
    (tmp_path / "map.yaml").write_text(
        f"image: map.png\nresolution: 0.05\norigin: [1, 2, 0]\nmode: {mode}\n"
        f"negate: {int(negate)}\noccupied_thresh: 0.63\nfree_thresh: 0.21\n"
    )

    cells = ServerMap.from_file(tmp_path / "map.yaml").cells

    for (row, column), found in np.ndenumerate(cells[::-1]):
        channels = [int(each) for each in pixels[row, column]]
        channels = channels * 3 if kind == "L" else channels
        assert found == cell(channels, mode, negate, 0.63, 0.21), channels


def test_walls_are_drawn():
    walls = np.array([[0.0, 0.0, 3.0, 0.0], [1.02, -1.0, 1.02, 1.0], [0.0, 0.0, 2.0, 1.0]])

    cells, resolution, origin = draw(walls)

    def at(x, y):
        return cells[int((y - origin.y) // resolution), int((x - origin.x) // resolution)]

    assert (resolution, set(cells.ravel().tolist())) == (0.05, {0, 100})
    assert at(1.5, 0.01) == at(1.021, -0.5) == at(1.01, 0.505) == 100
    assert at(2.5, 0.5) == at(-0.5, -0.5) == 0


@pytest.mark.parametrize("world", ["office", "test_room"])
def test_the_map_of_a_world(world, tmp_path):
    from flatland_server.config.worlds import find_world

    transport = LocalTransport()
    world = World.from_file(find_world(world), transport)

    OccupancyMap(world, transport)

    message = transport.last_latched("/map")
    assert message.header.frame_id == "map"
    cells = np.array(message.data).reshape(message.info.height, message.info.width)
    occupied = np.argwhere(cells == 100)[:, ::-1] + 0.5
    places = occupied * message.info.resolution
    places += [message.info.origin.position.x, message.info.origin.position.y]
    ends = world.layers[0].segments.reshape(-1, 2)
    assert places.min(axis=0) == pytest.approx(ends.min(axis=0), abs=0.06)
    assert places.max(axis=0) == pytest.approx(ends.max(axis=0), abs=0.06)
