"""Crowd: its topic, and what is refused."""

import math

import pytest
from townspeople import ROOM, SPEED, UPDATE, position, robot

from flatland_server.exceptions import FlatlandError
from flatland_server.simulation.world import World

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


def test_topic_frame_and_rate_can_be_chosen(town):
    keys = "poses_pub: /crowd, world_frame_id: earth, update_rate: 40"
    people = town("pose: [1, 2, 0.5]", keys=keys)

    messages = people.record("/crowd", 1.0)

    assert people.transport.topics == {"/crowd"}
    assert len(messages) == 40
    assert messages[0].header.frame_id == "earth"


def test_nothing_is_published_that_nobody_listens_to(town, deaf_transport):
    people = town("pose: [0, 0, 0], goals: [[9, 0]]", transport=deaf_transport).run(3.0)

    assert deaf_transport.published == []
    assert position(people)[0] > 2.0


# What is refused


@pytest.mark.parametrize(
    ("person", "message"),
    [
        pytest.param(
            "goals: [[1, 2]]",
            'pedestrians[0]: the required key "pose" is missing',
            id="no pose",
        ),
        pytest.param(
            "pose: [0, 0, 0], gaols: [[1, 2]]",
            'pedestrians[0]: unknown key "gaols" (did you mean "goals"?)',
            id="unknown key",
        ),
        pytest.param(
            "pose: [0, 0, 0], goals: []",
            "pedestrians[0].goals: expected a list of 1 to 10000 points [x, y], found []",
            id="no goals",
        ),
        pytest.param(
            "pose: [0, 0, 0], speed: 0",
            "pedestrians[0].speed: expected a number above 0, found 0",
            id="no speed",
        ),
        pytest.param(
            "pose: [0, 0, 0], radius: 0",
            "pedestrians[0].radius: expected a number of 0.01 or more, found 0",
            id="no radius",
        ),
        pytest.param(
            "pose: [0, 0, 0], legs: two",
            'pedestrians[0].legs: expected true or false, found "two"',
            id="legs",
        ),
        pytest.param(
            "pose: [0, 0, 0], name: little john",
            'pedestrians[0].name: expected a name of letters, digits and "_" (it names a ROS '
            'topic), found "little john"',
            id="a name with a space",
        ),
        pytest.param(
            "pose: [0, 0, 0], name: robot",
            'pedestrians[0].name: a model named "robot" is already there',
            id="a name that is taken",
        ),
        pytest.param(
            "pose: [0, 2.9, 0]",
            "pedestrians[0].pose: expected room for a radius of 0.25 m, found a wall after 0.1 m",
            id="in a wall",
        ),
        pytest.param(
            "pose: [3.9, 0, 0]",
            "pedestrians[0].pose: expected room for a radius of 0.25 m, found a model after 0.1 m",
            id="in a robot",
        ),
    ],
)  # fmt: skip
def test_a_wrong_entry_is_refused_at_its_line(town, files, person, message):
    with pytest.raises(FlatlandError) as caught:
        town(person, walls=ROOM, robots=robot(files, pose="[4.2, 0, 0]"))

    refusal = str(caught.value).replace(f"{files.folder}/", "")
    assert refusal == f"world.yaml:8: plugins[0].{message}"


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


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        pytest.param(
            "update_rat: 5",
            'plugins[0] "people": unknown key "update_rat" (did you mean "update_rate"?)',
            id="unknown key",
        ),
        pytest.param(
            "update_rate: 0",
            "plugins[0].update_rate: expected a number above 0, found 0",
            id="rate of zero",
        ),
        pytest.param(
            "layers: [mpa]",
            'plugins[0].layers: no layer is named "mpa" (did you mean "map"?); '
            "there are: map, other",
            id="unknown layer",
        ),
        pytest.param(
            "goal_radius: 0",
            "plugins[0].goal_radius: expected a number above 0, found 0",
            id="goal without size",
        ),
        pytest.param(
            "force: {rnage: 1}",
            'plugins[0].force: unknown key "rnage" (did you mean "range"?)',
            id="unknown key of force",
        ),
        pytest.param(
            "force: {relaxation_time: 0}",
            "plugins[0].force.relaxation_time: expected a number above 0, found 0",
            id="no relaxation time",
        ),
        pytest.param(
            "force: {side: rigth}",
            'plugins[0].force.side: expected right or left (did you mean "right"?), found "rigth"',
            id="side",
        ),
        pytest.param(
            "force: {noise: -1}",
            "plugins[0].force.noise: expected a number of 0 or more, found -1",
            id="negative noise",
        ),
    ],
)
def test_a_wrong_key_is_refused_at_its_line(town, files, keys, message):
    with pytest.raises(FlatlandError) as caught:
        town("pose: [0, 0, 0]", keys=keys)

    assert str(caught.value).replace(f"{files.folder}/", "") == f"world.yaml:6: {message}"


def test_a_crowd_needs_a_list_of_pedestrians_which_may_be_empty(town, files):
    town().run(1.0)
    path = files.write(
        "world.yaml",
        "properties: {}\nlayers: []\nplugins:\n  - {type: Crowd, name: people}\n",
    )

    with pytest.raises(FlatlandError) as caught:
        World.from_file(path, loader=files._loader)

    assert str(caught.value).replace(f"{files.folder}/", "") == (
        'world.yaml:4: plugins[0] "people": the required key "pedestrians" is missing'
    )
