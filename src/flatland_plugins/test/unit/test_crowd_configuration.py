"""Crowd: its topic, and refused configurations."""

import math

import pytest
from townspeople import ROOM, SPEED, UPDATE, position, robot

from flatland_server.exceptions import FlatlandError

# The topic


def test_poses_come_at_the_update_rate_with_the_time_they_are_of(town):
    people = town("pose: [1, 2, 0.5], goals: [[9, 2], [1, 2]]", "pose: [3, 4, -1]")

    messages = people.record("/people/poses", 1.0)

    assert [m.header.stamp.to_nsec() for m in messages] == [50_000_000 * i for i in range(20)]
    assert {m.header.frame_id for m in messages} == {"map"}
    first, last = messages[0].poses, messages[-1].poses
    assert (first[0].position.x, first[0].position.y) == pytest.approx((1.0, 2.0))
    assert 2 * math.atan2(first[1].orientation.z, first[1].orientation.w) == pytest.approx(-1.0)
    assert last[0].position.x == pytest.approx(position(people)[0], abs=UPDATE * SPEED)


# Refused configurations


POSITIVE = "expected a number above 0, found 0"
ROOM_FOR = "expected room for a radius of 0.25 m, found"


@pytest.mark.parametrize(
    ("person", "message"),
    [
        ("goals: []", "goals: expected a list of 1 to 10000 points [x, y], found []"),
        ("speed: 0", f"speed: {POSITIVE}"),
        ("radius: 0", "radius: expected a number of 0.01 or more, found 0"),
        ("name: little john", 'name: expected a name of letters, digits and "_"'),
        ("name: robot", 'name: a model named "robot" is already there'),
        ("pose: [0, 2.9, 0]", f"pose: {ROOM_FOR} a wall after 0.1 m"),
        ("pose: [3.9, 0, 0]", f"pose: {ROOM_FOR} a model after 0.1 m"),
    ],
)
def test_a_wrong_entry_is_refused_at_its_line(town, files, person, message):
    person = person if "pose" in person else f"pose: [0, 0, 0], {person}"
    with pytest.raises(FlatlandError) as caught:
        town(person, walls=ROOM, robots=robot(files, pose="[4.2, 0, 0]"))

    assert f"world.yaml:8: plugins[0].pedestrians[0].{message}" in str(caught.value)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ("layers: [mpa]", 'layers: no layer is named "mpa" (did you mean "map"?)'),
        ("goal_radius: 0", f"goal_radius: {POSITIVE}"),
        ("force: {relaxation_time: 0}", f"force.relaxation_time: {POSITIVE}"),
        ("force: {side: rigth}", 'force.side: expected right or left (did you mean "right"?)'),
        ("force: {noise: -1}", "force.noise: expected a number of 0 or more, found -1"),
    ],
)
def test_a_wrong_key_is_refused_at_its_line(town, files, keys, message):
    with pytest.raises(FlatlandError) as caught:
        town("pose: [0, 0, 0]", keys=keys)

    assert f"world.yaml:6: plugins[0].{message}" in str(caught.value)


def test_two_of_one_name_or_in_one_place_are_refused(town, files):
    with pytest.raises(FlatlandError) as named_alike:
        town("pose: [0, 0, 0], name: ann", "pose: [1, 0, 0], name: ann")
    with pytest.raises(FlatlandError) as too_near:
        town("pose: [0, 0, 0]", "pose: [0.4, 0, 0]")

    assert str(named_alike.value).endswith(
        'world.yaml:9: plugins[0].pedestrians[1].name: the name "ann" is given twice'
    )
    problem = "expected room for a radius of 0.25 m, found another pedestrian after 0.15 m"
    assert str(too_near.value).replace(f"{files.folder}/", "").splitlines() == [
        f"world.yaml:8: plugins[0].pedestrians[0].pose: {problem}",
        f"world.yaml:9: plugins[0].pedestrians[1].pose: {problem}",
    ]


def test_a_crowd_may_be_empty(town):
    assert town().run(1.0).last("/people/poses").poses == []
