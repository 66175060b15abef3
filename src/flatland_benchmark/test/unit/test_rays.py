"""Parts of the ray cases: outlines, exact distances, free poses, scenes."""

import math

import numpy as np
import pytest

from flatland_benchmark import scenes
from flatland_benchmark.exact_rays import (
    distances_to_circle,
    distances_to_polygon,
    distances_to_segments,
)
from flatland_benchmark.outlines import trace_outlines
from flatland_benchmark.ray_cases import differences
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


def test_no_ray_slips_through_where_walls_meet():
    corner = array([[0.1, 0.7], [1.3, 0.3], [2.9, -0.1]])
    walls = np.hstack([corner[:-1], corner[1:]])
    joint = corner[1]
    angles = np.linspace(-1.0, 1.0, 101)
    backwards = np.column_stack([np.cos(angles), np.sin(angles)])
    origins = joint - 0.7 * backwards

    distances = distances_to_segments(origins, backwards, walls)

    assert np.isfinite(distances).all()
    assert (distances <= 0.7 + 1e-9).all()


def test_many_rays_are_dealt_with_bit_by_bit(monkeypatch):
    angles = np.linspace(-3, 3, 50)
    rays = np.zeros((50, 2)), np.column_stack([np.cos(angles), np.sin(angles)])
    at_once = distances_to_segments(*rays, array(SQUARE) * 2 - 1)
    monkeypatch.setattr("flatland_benchmark.exact_rays._AT_ONCE", 13)

    assert distances_to_segments(*rays, array(SQUARE) * 2 - 1).tolist() == at_once.tolist()


def test_what_is_around_the_lidar_is_not_seen():
    square = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    ahead = array([[1, 0]])

    assert distances_to_circle(array([[0, 0]]), ahead, (0.0, 0.0), 1.0) == [math.inf]
    assert distances_to_polygon(array([[0, 0]]), ahead, square) == [math.inf]
    assert distances_to_polygon(array([[-3, 0.5]]), ahead, square) == [2.0]


@pytest.mark.parametrize("build", [scenes.room, scenes.room_with_bodies])
def test_flatland_box2d_and_arithmetic_see_the_same_scene(build):
    scene = build(None)
    angles = np.linspace(-2.0, 2.0, 201)
    fan = BeamFan(-2.0, 0.02, 201)
    directions = np.column_stack([np.cos(angles), np.sin(angles)])

    for pose in scene.poses[:5]:
        scene.world.physics.step(0.005)
        ours = scene.world.physics.scan(fan, pose, 50.0)[0]
        turned = angles + pose.yaw
        exact = scene.exact_distances(
            np.tile(pose[:2], (201, 1)), np.column_stack([np.cos(turned), np.sin(turned)])
        )
        for box2d in scene.in_box2d():
            assert box2d.scan(directions, pose, 50.0) == pytest.approx(exact, abs=1e-3)
        assert ours == pytest.approx(exact, abs=1e-3)


def test_a_range_that_is_wrong_is_found():
    scene = scenes.room(None)
    pose = scene.poses[0]
    exact = scene.exact_distances(
        array([pose[:2]]), array([[math.cos(pose.yaw), math.sin(pose.yaw)]])
    )

    def against(ours, theirs):
        return differences(scene, array([0.0]), 100.0, [(exact + ours, exact + theirs)])

    scene.poses = [pose]
    assert against(0.0, 0.0005) == (0, 0)
    assert against(0.0, 0.01) == (1, 0)
    assert against(0.01, 0.0) == (1, 1)
    assert against(math.inf, 0.0) == (1, 1)


def test_there_are_as_many_poses_and_bodies_as_said():
    scene = scenes.room_with_bodies(None)

    assert len(scene.poses) == scenes.POSES
    assert len(scene.bodies) == 50
    assert sum(len(body.footprints) == 2 for body in scene.bodies) == 25
