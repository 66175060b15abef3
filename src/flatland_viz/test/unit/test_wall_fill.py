"""The areas within walls, which the window fills (C++)."""

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from flatland_server.maps.wall_outlines import outlines

VIEW = Path(__file__).resolve().parents[2] / "src" / "view"

MAIN = """
#include <iostream>
#include "wall_fill.hpp"
int main() {
  std::vector<float> segments;
  for (float value; std::cin >> value;) segments.push_back(value);
  std::cout.precision(9);
  for (float value : flatland_viz::FillOf(segments)) std::cout << value << ' ';
}
"""


@pytest.fixture(scope="module")
def fill(tmp_path_factory):
    """The function FillOf: triangles, of shape (n, 3, 2)."""
    compiler = shutil.which("c++")
    if compiler is None:
        pytest.skip("there is no C++ compiler")
    folder = tmp_path_factory.mktemp("wall_fill")
    (folder / "main.cpp").write_text(MAIN)
    program = str(folder / "wall_fill")
    sources = [str(folder / "main.cpp"), str(VIEW / "wall_fill.cpp")]
    subprocess.run([compiler, "-std=c++17", f"-I{VIEW}", *sources, "-o", program], check=True)

    def call(segments):
        text = " ".join(map(repr, np.float32(segments).ravel().tolist()))
        run = subprocess.run([program], input=text, stdout=subprocess.PIPE, text=True, check=True)
        return np.array(run.stdout.split(), float).reshape(-1, 3, 2)

    return call


def covered(triangles, points):
    """The number of triangles that each point is in."""
    a, b, c = triangles[:, 0, None], triangles[:, 1, None], triangles[:, 2, None]

    def side(p, q):
        return np.cross(q - p, points - p)

    sides = np.stack([side(a, b), side(b, c), side(c, a)])
    return ((sides > 0).all(axis=0) | (sides < 0).all(axis=0)).sum(axis=0)


@pytest.mark.slow
@pytest.mark.parametrize("yaw", [0.0, 0.3])
def test_exactly_the_occupied_cells_of_an_image_are_filled(fill, yaw):
    bright = np.random.default_rng(1).random((12, 17)) < 0.6
    turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
    walls = outlines(bright).reshape(-1, 2) @ turn.T
    free_line = [[0.0, 0.0, 30.0, 0.1], [30.0, 0.1, 40.0, 40.0]]
    triangles = fill([*walls.reshape(-1, 4), *free_line])
    rows, columns = np.mgrid[0:12, 0:17]
    # Off the middles, where triangles of a cell meet.
    points = np.stack([columns + 0.53, 12 - rows - 0.41], axis=-1).reshape(-1, 2) @ turn.T
    assert (covered(triangles, points) == ~bright.ravel()).all()


@pytest.mark.slow
def test_a_long_wall_is_one_trapezoid(fill):
    corners = [(0, 0), (10, 0), (10, 1), (0, 1)]
    walls = [[*p, *q] for p, q in zip(corners, [*corners[1:], corners[0]])]
    assert len(fill(walls)) == 2
    assert len(fill(walls[:3])) == 0
