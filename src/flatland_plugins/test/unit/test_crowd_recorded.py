"""Crowd: people who walk as they were recorded."""

import numpy as np
import pytest
from townspeople import RADIUS, position, robot, walk

from flatland2d import Simulation
from flatland2d.rendering.scene import bounds
from flatland_server._core import AWAY
from flatland_server.exceptions import YamlError

ROWS = """\
780.0\t1.0\t8.0\t0.0
785.0\t1.0\t9.0\t0.0
790.0\t1.0\t9.0\t2.0
795.0\t2.0\t0.0\t4.0
805.0\t2.0\t2.0\t4.0
820.0\t3.0\t-3.0\t0.0
"""
"""As of ETH: with tabs, and two people who could be the same body."""


@pytest.fixture
def recorded(town, files):
    """A world of recorded people, at 5 frames per second."""

    def load(rows=ROWS, keys="", **options):
        (files.folder / "rows.txt").write_text(rows)
        section = f"recording: {{file: rows.txt, frame_rate: 5, {keys}}}"
        return town(keys=section, **options)

    return load


def test_people_walk_straight_from_frame_to_frame(recorded):
    people = recorded()

    path = walk(people, 2.0)[:, 0]

    assert path[100] == pytest.approx((8.5, 0.0), abs=0.01)  # halfway to the second frame
    assert path[199] == pytest.approx((9.0, 0.0), abs=0.01)
    assert path[300] == pytest.approx((9.0, 1.0), abs=0.02)
    assert np.hypot(*np.diff(path, axis=0).T).max() < 2.1 * 0.005  # at most 2 m/s


def test_a_body_shows_people_who_come_and_go(recorded):
    people = recorded()
    messages = people.record("/people/poses", 9.0)

    assert len(people.world.models) == 1  # with a pause of a second between the two
    assert len(recorded(ROWS.replace("795", "790")).world.models) == 2  # without one
    there = [len(each.poses) for each in messages]  # at 20 Hz
    assert there[:41] == [1] * 41
    assert sum(there[42:60]) == 0
    assert there[61:100] == [1] * 39
    assert sum(there[102:161]) == 0
    assert there[161] == 1  # in a single frame
    assert sum(there[162:]) == 0
    first = messages[61].poses[0]
    assert first.position.y == pytest.approx(4.0)
    assert first.orientation.z == pytest.approx(0.0)  # it faces its way from the beginning


def test_a_picture_excludes_people_who_are_away(recorded, files):
    people = recorded(keys="start: [2.5, 2.5]", robots=robot(files))

    assert people.model("people_0").is_away
    assert position(people)[0] >= AWAY
    with Simulation(files.folder / "world.yaml") as simulation:
        low, high = bounds(simulation.world)
    assert max(*map(abs, low), *map(abs, high)) < 1.0


def test_the_recordings_frame_is_in_the_world(recorded):
    people = recorded(keys="pose: [1, 2, 1.5707963]")

    people.run()

    assert position(people) == pytest.approx((1.0, 10.0), abs=0.02)


def test_a_robot_in_the_way_is_pushed_and_the_walk_goes_on(recorded, files):
    people = recorded(robots=robot(files, pose="[9, 1, 0]"))

    walk(people, 2.0)

    assert position(people) == pytest.approx((9.0, 2.0), abs=0.3)
    assert people.model("robot").pose.y > 1.0 + RADIUS


def test_a_start_is_drawn_by_the_seed(recorded):
    def first(seed):
        return position(recorded(keys="start: [0, 1.9]", seed=seed))

    assert first(1) == first(1)
    assert first(1) != first(2)


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ("", "rows.txt: expected rows of frame, id, x, y, found none"),
        ("frame,id,x,y\n# none\n\n", "rows.txt: expected rows of frame, id, x, y, found none"),
        ("1,1,0,0\n1,2,0\n", "rows.txt:2: expected four numbers, frame, id, x, y, found '1,2,0'"),
        ("0 1 2 nan", "rows.txt:1: expected four numbers, frame, id, x, y, found '0 1 2 nan'"),
        ("0 1 0 0\n0 1 1 1", "rows.txt:2: person 1 is in frame 0 a second time"),
        ("0 1 0 6e4", "rows.txt:1: expected a position within 50000 m, found [0.0, 60000.0]"),
        ("0.5 1 0 0", "rows.txt:1: expected a whole frame and id, found 0.5, 1"),
        ("0 1 0 0\n1e9 1 0 0", "frame_rate: expected a recording of up to 1e+06 s, found 2e+08 s"),
    ],
)
def test_a_wrong_file_is_refused_at_its_line(recorded, rows, message):
    with pytest.raises(YamlError) as caught:
        recorded(rows)

    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ("start: [3, 2]", "start: expected ascending times, found [3, 2]"),
        ("start: [0, 99]", "start: expected times up to the end, 8 s, found 99"),
        ("speed: 1", 'unknown key "speed"'),
    ],
)
def test_wrong_keys_are_refused(recorded, keys, message):
    with pytest.raises(YamlError) as caught:
        recorded(keys=keys)

    assert "plugins[0].recording" in str(caught.value)
    assert message in str(caught.value)
