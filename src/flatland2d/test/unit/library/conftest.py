"""Simulations for the tests of the library."""

import pytest
from library.parts import BODY, LOADER, ROBOT, WALLS

from flatland2d import Simulation


@pytest.fixture
def world(tmp_path):
    """A room with a robot, a box, and a robot with a body that is not at its origin."""
    (tmp_path / "map.dat").write_text(WALLS)
    (tmp_path / "map.yaml").write_text(
        "{type: line_segments, data: map.dat, scale: 1, origin: [0, 0, 0]}"
    )
    return {
        "properties": {},
        "layers": [{"name": "walls", "map": tmp_path / "map.yaml"}],
        "models": [
            {"name": "robot", "model": ROBOT, "pose": [0, 0, 0.5]},
            {"name": "box", "model": {"bodies": [BODY]}, "pose": [1, 1, 4]},
        ],
    }


@pytest.fixture
def sim(world):
    with Simulation(world, loader=LOADER) as simulation:
        yield simulation
