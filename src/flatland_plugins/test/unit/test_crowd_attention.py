"""Crowd: people who do not give way, groups, drawn places and ORCA."""

import math

import numpy as np
import pytest
from townspeople import CALM, RADIUS, ROOM, TOWARDS_EACH_OTHER, least_gap, position, robot, walk

from flatland_server.exceptions import FlatlandError

TOWARDS_THE_ROBOT = "pose: [-4, 0, 0], goals: [[4, 0], [9, 0]]"
TOUCH = 0.2 + RADIUS


def nearest(town, files, person: str, speed: float = 0.1, keys: str = CALM) -> float:
    """The least distance of a person from a heavy robot that comes slowly [m]."""
    disc = "{type: circle, radius: 0.2, density: 100000}"
    people = town(f"{TOWARDS_THE_ROBOT}, {person}", keys=keys, robots=robot(files, footprint=disc))
    people.model("robot").base.physics_body.velocity = (-speed, 0.0, 0.0)
    path = walk(people, 8.0, "people_0", "robot")
    return float(np.linalg.norm(path[:, 0] - path[:, 1], axis=-1).min())


# Giving way to robots


@pytest.mark.parametrize("speed", [0.0, 0.1])
@pytest.mark.parametrize(
    ("keys", "motion"),
    [
        ("sees_robots: false", "social_force"),
        ("sees_robots: false", "orca"),
        ("field_of_view: 0", "social_force"),
    ],
)
def test_people_who_see_no_robots_walk_into_them(town, files, keys, motion, speed):
    found = nearest(town, files, keys, speed, f"{CALM}, motion: {motion}")
    assert found == pytest.approx(TOUCH, abs=0.02)


@pytest.mark.parametrize("motion", ["social_force", "orca"])
@pytest.mark.parametrize("keys", ["yields: 0", "reaction_time: 30"])
def test_unyielding_people_still_avoid_standing_robots(town, files, keys, motion):
    person, crowd = f"{keys}, field_of_view: 3", f"{CALM}, motion: {motion}"
    assert nearest(town, files, person, 0.0, crowd) > TOUCH + 0.02
    assert nearest(town, files, person, 0.1, crowd) < TOUCH + 0.01


def test_unyielding_people_still_avoid_people_and_walls(town):
    keys = "force: {noise: 0}, sees_robots: false"
    people = town(*TOWARDS_EACH_OTHER, keys=keys, walls=("4.5 -9 4.5 9",))

    path = walk(people, 8.0, "people_0", "people_1")

    assert least_gap(path) > 0.05
    assert path[:, 0, 0].max() < 4.5 - RADIUS


def test_an_entry_may_see_robots_in_a_crowd_that_does_not(town, files):
    assert nearest(town, files, "sees_robots: true, yields: 1") > TOUCH + 0.1


def test_a_longer_reaction_time_means_passing_closer(town, files):
    # The robot is seen at 5 m, 3 s away: within a second nothing is lost.
    distances = [nearest(town, files, f"reaction_time: {t}") for t in (0.0, 2.6, 30.0)]

    assert distances[0] > distances[1] + 0.01
    assert distances[2] == pytest.approx(TOUCH, abs=0.02)


def test_the_share_of_people_that_yield_is_the_probability(town, files):
    lanes = range(60)
    model = files.model("robot", footprint="{type: circle, radius: 0.2, density: 100000}")
    robots = {f"robot_{lane}": f"model: {model}, pose: [0, {12 * lane}, 0]" for lane in lanes}
    people = town(
        *(f"pose: [-3, {12 * k}, 0], goals: [[9, {12 * k}], [-9, {12 * k}]]" for k in lanes),
        keys=f"{CALM}, yields: 0.3",
        robots=robots,
    )
    for name in robots:
        people.model(name).base.physics_body.velocity = (-0.1, 0.0, 0.0)
    path = walk(people, 4.0, *(f"people_{k}" for k in lanes), *robots)

    distances = np.linalg.norm(path[:, : len(lanes)] - path[:, len(lanes) :], axis=-1)
    walked_into = distances.min(axis=0) < TOUCH + 0.05

    # 42 expected; binomial, 4 standard deviations
    assert abs(int(walked_into.sum()) - 42) < 4 * math.sqrt(60 * 0.3 * 0.7)


def test_standing_people_who_see_no_robots_do_not_move(town, files):
    people = town("pose: [0.7, 0, 0]", keys=f"{CALM}, sees_robots: false", robots=robot(files))

    people.run(3.0)

    assert position(people) == pytest.approx((0.7, 0.0), abs=1e-3)


# Groups


def test_a_group_waits_for_its_slower_members(town):
    def spread(keys: str) -> float:
        people = town(
            f"pose: [0, 0, 0], goals: [[40, 0]], speed: 1.4{keys}",
            f"pose: [0, 1, 0], goals: [[40, 1]], speed: 0.9{keys}",
            keys=CALM,
        )
        path = walk(people, 12.0, "people_0", "people_1")
        return float(np.linalg.norm(path[-1, 0] - path[-1, 1]))

    assert spread("") > 5.0
    assert spread(", group: pair") < 2.5


# Drawn places


def test_drawn_people_depend_on_the_seed_and_stay_in_the_area(town):
    keys = "random: {count: 6, standing: 2, area: [[-4, -2], [4, 2]]}"
    names = [f"people_{i}" for i in range(6)]
    starts = []
    for seed in (1, 1, 2):
        people = town(keys=keys, walls=ROOM, seed=seed)
        starts.append([position(people, name) for name in names])
    path = walk(people, 20.0, *names)

    assert starts[0] == starts[1]
    assert starts[0] != starts[2]
    travelled = np.linalg.norm(np.diff(path, axis=0), axis=-1).sum(axis=0)
    assert travelled[2:].min() > 5.0
    assert np.linalg.norm(path[-1, :2] - path[0, :2], axis=-1).max() < 1.0
    assert np.abs(path[..., 0]).max() < 5 - RADIUS
    assert np.abs(path[..., 1]).max() < 3 - RADIUS


def test_a_drawn_crowd_may_be_empty(town):
    people = town(keys="random: {count: 0, area: [[0, 0], [1, 1]]}, circle: {count: 0, radius: 1}")
    people.step()
    assert list(people.world.models) == []


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ("yields: 1.5", "yields: expected a number up to 1, found 1.5"),
        ("yields: -1", "yields: expected a number of 0 or more"),
        ("random: {area: [[0, 0], [1, 1]]}", 'random: the required key "count" is missing'),
        ("random: {count: 1, area: [[0, 0]]}", "random.area: expected a list of 2"),
        (
            "random: {count: 1, standing: 2, area: [[0, 0], [1, 1]]}",
            "expected at most the count, 1",
        ),
        ("random: {count: 50, area: [[0, 0], [1, 1]]}", "expected room for a radius"),
        ("circle: {count: -1, radius: 2}", "circle.count: expected"),
        ("motion: orcas", "motion: expected"),
    ],
)
def test_wrong_keys_are_refused(town, keys, message):
    with pytest.raises(FlatlandError) as caught:
        town("pose: [9, 9, 0]", keys=keys)
    assert message in str(caught.value)


# ORCA


def test_with_orca_forty_cross_a_circle_without_touching(town):
    people = town(keys="motion: orca, circle: {count: 40, radius: 8}")
    names = [f"people_{i}" for i in range(40)]

    path = walk(people, 40.0, *names)

    assert least_gap(path[::10]) > -0.02
    assert path[-1] == pytest.approx(-path[0], abs=0.4)


@pytest.mark.parametrize("noise", ["", "force: {noise: 0}, "])
def test_with_orca_noise_resolves_the_deadlock_on_a_circle(town, noise):
    angles = [k * math.tau / 8 for k in range(8)]
    places = [(4.0 * math.cos(angle), 4.0 * math.sin(angle)) for angle in angles]
    persons = [f"pose: [{x}, {y}, 0], goals: [[{-x}, {-y}]]" for x, y in places]
    people = town(*persons, keys=f"{noise}motion: orca").run(40.0)

    left = [math.dist(position(people, f"people_{k}"), (-x, -y)) for k, (x, y) in enumerate(places)]
    assert min(left) > 3.0 if noise else max(left) < 0.3


def test_with_orca_they_stay_behind_walls_and_pass_robots(town, files):
    people = town(
        TOWARDS_THE_ROBOT,
        keys="motion: orca",
        walls=("-9 1.2 3 1.2", "-9 -1.2 3 -1.2"),
        robots=robot(files),
    )
    path = walk(people, 8.0)[:, 0]

    assert np.linalg.norm(path, axis=-1).min() > TOUCH - 0.01
    beside = path[path[:, 0] < 2.9]
    assert np.abs(beside[:, 1]).max() < 1.2 - RADIUS + 0.01
    assert path[-1, 0] > 3.7
    assert people.model("robot").pose == pytest.approx((0.0, 0.0, 0.0), abs=1e-3)
