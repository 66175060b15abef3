"""Crowd: people among each other, walls and robots."""

import math
from typing import Tuple

import numpy as np
import pytest
from townspeople import (
    CALM,
    RADIUS,
    ROOM,
    SPEED,
    TAU,
    TOWARDS_EACH_OTHER,
    least_gap,
    position,
    robot,
    two_crowds,
    velocity,
    walk,
)

from flatland_server import Circle

pytestmark = pytest.mark.slow

DRIVE = "type: DiffDrive, name: drive, body: base"
BLIND = "force: {noise: 0, repulsion: 0, evasion: 0}"


def least_distance(path: np.ndarray, point: Tuple[float, float]) -> float:
    return float(np.linalg.norm(path - np.array(point), axis=-1).min())


# Each other


@pytest.mark.parametrize(("side", "sign"), [("right", -1.0), ("left", 1.0)])
def test_two_people_head_on_pass_on_the_preferred_side(town, side, sign):
    keys = f"force: {{noise: 0, side: {side}}}"
    people = town(*TOWARDS_EACH_OTHER, keys=keys)

    path = walk(people, 7.0, "people_0", "people_1")

    apart = np.linalg.norm(path[:, 0] - path[:, 1], axis=1)
    assert least_gap(path) > 0.05
    assert path[apart.argmin(), 0, 1] * sign > RADIUS
    assert path[apart.argmin(), 1, 1] * sign < -RADIUS
    # 8 m at 1.34 m/s, and some seconds to speed up and to pass
    assert path[-1, 0, 0] > 3.7
    assert path[-1, 1, 0] < -3.7


@pytest.mark.slow
def test_twenty_people_cross_a_square_and_arrive(town):
    angles = [math.tau * i / 20 for i in range(20)]
    spots = [(5 * math.cos(a), 5 * math.sin(a)) for a in angles]
    people = town(*(f"pose: [{x}, {y}, 0], goals: [[{-x}, {-y}]]" for x, y in spots))
    names = [f"people_{i}" for i in range(20)]

    path = walk(people, 30.0, *names)

    assert least_gap(path) > -0.02  # bodies are hard
    for (x, y), arrived in zip(spots, path[-1]):
        assert arrived == pytest.approx((-x, -y), abs=0.1)


@pytest.mark.parametrize("keys", [CALM, f"{CALM}, sees_robots: false"])  # they are no robots
def test_two_crowds_give_way_to_each_other(town, files, keys):
    way = walk(two_crowds(town, files, keys), 7.0, "people_0", "others_0")

    assert least_gap(way) > 0.05
    assert way[-1, 0, 0] > 3.7
    assert way[-1, 1, 0] < -3.7


def test_two_standing_people_move_apart_until_forces_balance(town):
    keys = "force: {noise: 0, evasion: 0}"
    people = town("pose: [0, 0, 0]", "pose: [0.55, 0, 0]", keys=keys).run(20.0)

    # Each is drawn back to its place, half of what the gap has grown by: A exp(-gap / B) is the
    # driving force way / (2 tau) / tau, where way = (gap - 0.05) / 2.
    gap = math.dist(position(people, "people_0"), position(people, "people_1")) - 2 * RADIUS
    assert 25.0 * math.exp(-gap / 0.08) == pytest.approx((gap - 0.05) / 4 / TAU**2, rel=0.02)
    assert gap > 0.15


def test_a_large_force_does_not_exceed_the_speed_of_people(town):
    keys = "force: {noise: 0, repulsion: 10000}"
    people = town("pose: [0.25, 0, 0], speed: 1.2", keys=keys, walls=("0 -9 0 9",)).run()

    assert velocity(people) == pytest.approx((1.3 * 1.2, 0.0), abs=1e-5)


# Walls


@pytest.mark.parametrize("radius", [0.2, 0.3])
def test_people_stop_where_wall_and_goal_forces_balance(town, radius):
    person = f"pose: [0, 0, 0], goals: [[9, 0], [9, 9]], radius: {radius}, speed: 1.2"
    people = town(person, keys=CALM, walls=("2 -9 2 9",))

    people.run(10.0)

    # A exp(-gap / B) = v0 / tau, with 25 m/s^2 and 8 cm
    gap = 0.08 * math.log(25.0 * TAU / 1.2)
    assert position(people) == pytest.approx((2.0 - radius - gap, 0.0), abs=2e-3)


def test_through_a_door_but_not_through_the_wall(town):
    door = ("0 -3 0 -0.45", "0 0.45 0 3")
    people = town(
        "pose: [-3, 1.5, 0], goals: [[3, -1.5], [-3, 1.5]]",
        "pose: [-3, -1.5, 0], goals: [[3, 1.5], [-3, -1.5]]",
        walls=(*ROOM, *door),
    )

    path = walk(people, 60.0, "people_0", "people_1")

    for person in range(2):
        x, y = path[:, person].T
        at_the_wall = np.abs(x) < RADIUS - 0.02
        assert (np.abs(y[at_the_wall]) < 0.45).all()
        assert (np.diff(np.sign(x)) != 0).sum() >= 3
        assert np.abs(x).max() < 5 - RADIUS
        assert np.abs(y).max() < 3 - RADIUS


def test_a_wall_that_is_put_up_later_holds_them_too(town):
    people = town("pose: [0, 0, 0], goals: [[9, 0], [9, 9]]", keys=CALM).run(1.0)

    people.world.add_walls("map", np.array([[4.0, -9.0, 4.0, 9.0]]))
    people.run(8.0)

    gap = 0.08 * math.log(25.0 * TAU / SPEED)
    assert position(people) == pytest.approx((4.0 - RADIUS - gap, 0.0), abs=2e-3)


# Robots


@pytest.mark.parametrize(("offset", "radius"), [(0.0, 0.2), (0.1, 0.2), (-0.1, 0.2), (0.1, 0.8)])
def test_a_robot_in_the_way_is_passed_at_a_distance(town, files, offset, radius):
    """Also if its outline has changed."""
    person = f"pose: [-4, {offset}, 0], goals: [[4, {offset}], [9, 0]]"
    people = town(person, robots=robot(files))
    if radius != 0.2:
        people.model("robot").set_footprint("base", 0, Circle((0.0, 0.0), radius))

    path = walk(people, 8.0 if radius == 0.2 else 10.0)

    assert least_distance(path, (0.0, 0.0)) > radius + RADIUS + 0.05
    assert path[-1, 0, 0] > 3.7
    assert people.model("robot").pose == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)


def test_people_avoid_the_outline_of_a_long_robot(town, files):
    beam = (
        "{type: polygon, points: [[-1.5, -0.1], [1.5, -0.1], [1.5, 0.1], [-1.5, 0.1]], density: 99}"
    )
    aisle = ("-9 1 9 1", "-9 -0.6 9 -0.6")
    people = town(
        "pose: [-5, 0.5, 0], goals: [[5, 0.5], [-5, 0.5]]",
        walls=aisle,
        robots=robot(files, footprint=beam, pose="[0, -0.2, 0]"),
    )

    path = walk(people, 12.0)[:, 0]

    beside = path[np.abs(path[:, 0]) < 1.5]
    assert len(beside) > 0
    assert beside[:, 1].min() > -0.1 + RADIUS
    assert path[:, 0].max() > 4.7


@pytest.mark.parametrize("footprint", ["collision: false", "sensor: true", "layers: [other]"])
def test_people_do_not_avoid_what_they_cannot_touch(town, files, footprint):
    disc = f"{{type: circle, radius: 0.2, density: 10, {footprint}}}"
    person, robots = "pose: [-4, 0, 0], goals: [[4, 0]]", robot(files, footprint=disc)
    people = town(person, keys=f"layers: [map], {CALM}", robots=robots)

    assert least_distance(walk(people, 8.0), (0.0, 0.0)) < 0.01


def test_walls_of_other_layers_do_not_count(town):
    people = town("pose: [0, 0, 0], goals: [[9, 0]]", keys="layers: [other]", walls=("2 -9 2 9",))

    assert position(people.run(10.0)) == pytest.approx((9.0, 0.0), abs=0.05)


def test_standing_people_make_way_for_a_robot_and_return(town, files):
    people = town("pose: [1, 0, 0]", keys=CALM, robots=robot(files, DRIVE)).drive(0.5)

    gaps = []
    for _ in range(40):
        people.run(0.1)
        gaps.append(math.dist(position(people), position(people, "robot")) - 0.2 - RADIUS)
    away = position(people)
    people.drive(-1.0).run(6.0)

    assert math.dist(away, (1.0, 0.0)) > 0.5
    assert min(gaps) > 0.0
    assert position(people) == pytest.approx((1.0, 0.0), abs=0.02)


def test_a_heavy_robot_pushes_people_who_do_not_make_way(town, files):
    tank = "{type: circle, radius: 0.2, density: 100000}"
    robots = robot(files, DRIVE, footprint=tank)
    people = town("pose: [1, 0, 0]", keys=BLIND, robots=robots).drive(0.5).run(4.0)

    assert people.model("robot").pose.x == pytest.approx(2.0, abs=0.05)
    assert position(people)[0] == pytest.approx(people.model("robot").pose.x + 0.45, abs=0.03)


def test_walking_people_push_a_light_box(town, files):
    people = town("pose: [-2, 0, 0], goals: [[9, 0]]", keys=BLIND, robots=robot(files)).run(4.0)

    assert position(people)[0] > 1.0
    assert people.model("robot").pose.x == pytest.approx(position(people)[0] + 0.45, abs=0.1)
