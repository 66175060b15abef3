"""The benchmark's worlds: robots all over the office, free of walls and of each other."""

from pathlib import Path

import numpy as np
import pytest

from flatland_benchmark.robot_worlds import floor, free_poses, write_world
from flatland_server.maps.map_reader import MapConfig
from flatland_server.simulation.run import Run
from flatland_server.simulation.world import World
from flatland_server.timekeeper import Timekeeper

WORLDS = Path(__file__).resolve().parents[3] / "flatland_server" / "worlds"
RADIUS = 0.18  # of a robot [m]
OFFICE = WORLDS / "office" / "office.yaml"


@pytest.fixture(scope="module")
def space():
    """The office's floor, as far from its walls as robots are put."""
    return floor(WORLDS, 0.3)


def distances_to_segments(places, segments):
    """Shape (places, segments)."""
    begin, along = segments[:, :2], segments[:, 2:] - segments[:, :2]
    offsets = places[:, np.newaxis] - begin
    part = np.clip((offsets * along).sum(axis=2) / (along**2).sum(axis=1), 0, 1)
    return np.linalg.norm(offsets - part[..., np.newaxis] * along, axis=2)


@pytest.mark.parametrize("count", [1, 100, pytest.param(1000, marks=pytest.mark.slow)])
def test_places_are_clear_of_walls_and_of_each_other(space, count):
    places = np.array(free_poses(space, count))[:, :2]

    between = np.linalg.norm(places[:, np.newaxis] - places, axis=2)
    to_walls = distances_to_segments(places, MapConfig.from_file(OFFICE).walls())

    assert places.shape == (count, 2)
    assert np.min(between[~np.eye(count, dtype=bool)], initial=np.inf) > 2 * RADIUS
    assert to_walls.min() > RADIUS


def test_places_are_inside_and_all_over_the_office(space):
    places = np.array(free_poses(space, 100))[:, :2]

    assert np.all(np.abs(places - [2.5, 0.0]) < [32.5, 12.5])
    quarters = {(x > 0, y > 0) for x, y in places}
    assert len(quarters) == 4
    assert np.ptp(places, axis=0) == pytest.approx([62, 23], abs=3)


def test_places_are_the_same_each_time(space):
    assert free_poses(space, 20) == free_poses(space, 20)


@pytest.mark.slow
def test_more_robots_than_places_are_refused(space):
    with pytest.raises(ValueError, match=r"5000 robots do not fit, only \d+"):
        free_poses(space, 5000)


def test_robots_of_a_world_have_plugins_and_topics_of_their_own(tmp_path):
    world = World.from_file(write_world(tmp_path, WORLDS, 3))
    Run(world, Timekeeper(0.005)).step(20)

    assert list(world.models) == ["robot_0", "robot_1", "robot_2"]
    scan = world.transport.last("robot_2/scan")
    assert len(scan.ranges) == 1081
    assert np.isfinite(scan.ranges).any()
    assert world.transport.last("robot_1/odometry/filtered") is not None


def test_robots_stay_where_they_are_put(tmp_path):
    world = World.from_file(write_world(tmp_path, WORLDS, 50))
    before = [model.base.pose for model in world.models.values()]
    Run(world, Timekeeper(0.005)).step(20)

    after = [model.base.pose for model in world.models.values()]
    assert np.array(after) == pytest.approx(np.array(before), abs=1e-6)


def test_a_world_without_robots_is_just_the_office(tmp_path):
    world = World.from_file(write_world(tmp_path, WORLDS, 0))

    assert not world.models
    assert len(world.layers[0].segments) > 1000
