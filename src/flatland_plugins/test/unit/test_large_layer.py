"""A map of so many walls that Box2D has only those near robots: collisions and scans."""

import numpy as np
import pytest
from PIL import Image

from flatland2d import Simulation

pytestmark = pytest.mark.slow

SPECKS = 0.12
PIXELS = 1300
SIZE = 0.05 * PIXELS  # m

WORLD = """\
properties: {}
layers: [{name: specks, map: map.yaml}]
models:
- name: robot
  pose: [32.5, 32.5, 0.3]
  model:
    bodies:
    - {name: base, footprints: [{type: circle, radius: 0.2, density: 10}]}
    plugins:
    - {type: DiffDrive, name: drive, body: base}
    - {type: Laser, name: laser, body: base, frame: laser, range: 20,
       angle: {min: -3, max: 3, increment: 0.01}, update_rate: 10}
    - {type: Bumper, name: bumper}
"""


@pytest.fixture(scope="module")
def world(tmp_path_factory):
    """Specks all around a clear square of 5 x 5 m."""
    folder = tmp_path_factory.mktemp("large")
    pixels = np.full((PIXELS, PIXELS), 255, np.uint8)
    pixels[np.random.default_rng(1).random(pixels.shape) < SPECKS] = 0
    middle = slice(PIXELS // 2 - 50, PIXELS // 2 + 50)
    pixels[middle, middle] = 255
    Image.fromarray(pixels).save(folder / "map.png")
    (folder / "map.yaml").write_text(
        "{image: map.png, resolution: 0.05, origin: [0, 0, 0], occupied_thresh: 0.5}"
    )
    path = folder / "world.yaml"
    path.write_text(WORLD)
    return path


def drive(simulation: Simulation, seconds: float):
    """Drives for a time [s]; returns the robot's poses, scans and collisions."""
    robot = simulation.models["robot"]
    seen = []
    for _ in range(round(seconds / 0.1)):
        robot.command(1.0, 0.2)
        simulation.step(20)
        bumped = str(simulation.last("/collisions").collisions)
        seen.append((robot.pose, robot.sensors["laser"].read().tolist(), bumped))
    return seen


def test_a_run_saved_among_specks_continues_with_the_same_bits(world):
    with Simulation(world) as simulation:
        [layer] = simulation.world.layers
        assert len(layer.segments) > 500_000
        first = drive(simulation, 4.0)
        [collision] = simulation.last("/collisions").collisions[:1]
        assert {collision.entity_A, collision.entity_B} == {"robot", "specks"}
        state = simulation.save_state()
        then = drive(simulation, 4.0)

        simulation.load_state(state)
        assert drive(simulation, 4.0) == then
        simulation.reset()
        assert drive(simulation, 4.0) == first

        simulation.move("robot", (SIZE + 20.0, 30.0, 0.0))
        assert drive(simulation, 0.5)[-1][0].x > SIZE + 20.0
