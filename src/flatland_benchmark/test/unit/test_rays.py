"""Parts of the ray cases: outlines and scenes."""

import numpy as np
import pytest

from flatland_benchmark import scenes
from flatland_benchmark.outlines import trace_outlines
from flatland_server._core import BeamFan

SQUARE = [[0, 0, 1, 0], [1, 0, 1, 1], [1, 1, 0, 1], [0, 1, 0, 0]]


def array(rows):
    return np.array(rows, dtype=float)


def test_a_shuffled_outline_is_walked_around():
    [outline] = trace_outlines(array([SQUARE[2], SQUARE[0], SQUARE[3], SQUARE[1]]))

    assert outline.tolist() == [SQUARE[2], SQUARE[3], SQUARE[0], SQUARE[1]]


def test_a_crossing_loses_no_segment():
    crossing = array([[-1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])

    outlines = trace_outlines(crossing)

    both_ways = {tuple(row) for row in crossing} | {(*row[2:], *row[:2]) for row in crossing}
    rows = [tuple(row) for row in np.concatenate(outlines)]
    assert len(rows) == 4
    assert both_ways.issuperset(rows)
    for outline in outlines:
        assert outline[1:, :2].tolist() == outline[:-1, 2:].tolist()


@pytest.mark.parametrize("build", [scenes.room, scenes.bodies])
def test_flatland_and_box2d_see_the_same_scene(build):
    scene = build(None)
    angles = np.linspace(-2.0, 2.0, 201)
    fan = BeamFan(-2.0, 0.02, 201)
    directions = np.column_stack([np.cos(angles), np.sin(angles)])

    for pose in scene.poses[:5]:
        scene.world.physics.step(0.005)
        ours = scene.world.physics.scan(fan, pose, 50.0)[0]
        assert np.isfinite(ours).all()
        for box2d in scene.in_box2d():
            assert box2d.scan(directions, pose, 50.0) == pytest.approx(ours, abs=2e-3)


def test_the_scene_of_bodies_has_50_bodies_and_all_poses():
    scene = scenes.bodies(None)

    assert len(scene.poses) == scenes.POSES
    assert len(scene.bodies) == 50
    assert sum(len(body.footprints) == 2 for body in scene.bodies) == 25
