"""Box2D steps without reading the clock, and computes the same as if it did."""

import subprocess
import sys
from pathlib import Path

import pytest

BUSY_WORLD = """
import ctypes, hashlib, sys
for library in sys.argv[1:]:
    ctypes.CDLL(library)
from flatland_server import _core

world = _core.World()
world.add_layer([[0, 0, 5, 0], [5, 0, 5, 5], [5, 5, 0, 5], [0, 5, 0, 0]], 1)
bodies = []
for i in range(25):
    body = world.add_body("dynamic", (0.5 + i % 5, 0.5 + i // 5, i))
    if i % 2:
        body.add_circle((0, 0), 0.3, density=1, restitution=0.9)
    else:
        body.add_polygon([(-0.3, -0.2), (0.3, -0.2), (0, 0.3)], density=1, friction=0.5)
    body.velocity = (i - 12, 12 - i, i)
    bodies.append(body)
digest = hashlib.sha256()
for _ in range(300):
    world.step(0.005)
    digest.update(repr([(body.pose, body.velocity) for body in bodies]).encode())
print(_core.box2d_reads_clock(), digest.hexdigest())
"""


def run_busy_world(*libraries):
    """Steps a world in which bodies hit each other and walls, in a process of its own.

    Args:
        libraries: loaded before the core.

    Returns:
        Whether Box2D reads the clock, and a digest of all poses and velocities.
    """
    command = [sys.executable, "-c", BUSY_WORLD, *libraries]
    output = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout
    reads_clock, digest = output.split()
    return reads_clock == "True", digest


def shared_box2d():
    """The shared library of Box2D that the core is linked with."""
    maps = Path("/proc/self/maps").read_text().splitlines()
    paths = {
        line.split()[-1] for line in maps if Path(line.split()[-1]).name.startswith("libbox2d")
    }
    if not paths:
        pytest.skip("Box2D is a static library here")
    return paths.pop()


def test_results_are_the_same_with_the_clock():
    """If Box2D is loaded first, by another module, it keeps its own timer."""
    without_clock = run_busy_world()
    with_clock = run_busy_world(shared_box2d())

    assert (without_clock[0], with_clock[0]) == (False, True)
    assert without_clock[1] == with_clock[1]
