"""Crowd: people on their way, among walls and robots, before lasers, and as models of the world."""

import logging
import math
from typing import Any, Callable, Dict, List, Tuple

import numpy as np
import pytest

from flatland_server.exceptions import FlatlandError
from flatland_server.geometry import Pose
from flatland_server.world import World

SPEED, RADIUS, TAU = 1.34, 0.25, 0.5
UPDATE = 0.05
DRIVE = "type: DiffDrive, name: drive, body: base"
LASER = (
    "type: Laser, name: laser, body: base, range: 5, "
    "angle: {min: -0.3, max: 0.3, increment: 0.0005}"
)
CALM = "force: {noise: 0}"
BLIND = "force: {noise: 0, repulsion: 0, evasion: 0}"
TOWARDS_EACH_OTHER = (
    "pose: [-4, 0, 0], goals: [[4, 0], [9, 0]]",
    "pose: [4, 0, 3.14], goals: [[-4, 0], [-9, 0]]",
)
ROOM = ("-5 -3 5 -3", "5 -3 5 3", "5 3 -5 3", "-5 3 -5 -3")


@pytest.fixture
def town(files, simulate) -> Callable[..., Any]:
    """Makes a world of people, the first one on line 8 of its file."""

    def load(
        *people: str,
        keys: str = "",
        walls: Tuple[str, ...] = (),
        robots: Dict[str, str] = {},  # noqa: B006 (only read)
        **options: Any,
    ) -> Any:
        layer = f"{{name: map, map: {files.walls('map', *walls)}}}" if walls else "{name: map}"
        lines = [
            "properties: {}",
            f"layers: [{layer}, {{name: other}}]",
            f"models: [{', '.join(f'{{name: {n}, {entry}}}' for n, entry in robots.items())}]",
            "plugins:",
            "  - type: Crowd",
            f"    <<: {{{keys}}}",
            "    pedestrians:" + (" []" if not people else ""),
            *(f"      - {{{person}}}" for person in people),
            "    name: people",
        ]
        path = files.write("world.yaml", "\n".join(lines))
        return simulate(World.from_file(path, **{"loader": files._loader, **options}))

    return load


def robot(files, *plugins: str, pose: str = "[0, 0, 0]", **options: Any) -> Dict[str, str]:
    """A disc of 0.2 m, if not told otherwise, for `town`."""
    return {"robot": f"model: {files.model('robot', *plugins, **options)}, pose: {pose}"}


def position(town: Any, name: str = "people_0") -> Tuple[float, float]:
    return tuple(town.model(name).pose[:2])


def velocity(town: Any, name: str = "people_0") -> Tuple[float, float]:
    return tuple(town.model(name).base.physics_body.velocity[:2])


def walk(town: Any, seconds: float, *names: str) -> np.ndarray:
    """Where people go meanwhile: shape (steps, persons, 2)."""
    path = []
    for _ in range(round(seconds / 0.005)):
        town.run()
        path.append([position(town, name) for name in names or ("people_0",)])
    return np.array(path)


def least_distance(path: np.ndarray, point: Tuple[float, float]) -> float:
    return float(np.linalg.norm(path - np.array(point), axis=-1).min())


# On the way


def test_speed_builds_up_to_the_desired_one_within_the_relaxation_time(town):
    people = town("pose: [0, 0, 0], goals: [[100, 0], [0, 0]], speed: 1.2", keys=CALM)

    for update in range(1, 60):
        people.run(UPDATE)
        expected = 1.2 * (1.0 - math.exp(-update * UPDATE / TAU))
        assert velocity(people) == pytest.approx((expected, 0.0), abs=1e-5)
    # Box2D moves on at the velocity that each update ends with: 1.2 t less what is left over.
    updates = np.arange(1, 60)
    way = (1.2 * (1.0 - np.exp(-updates * UPDATE / TAU)) * UPDATE).sum()
    assert position(people) == pytest.approx((way, 0.0), abs=1e-3)


def test_goals_are_visited_in_turn_and_again(town):
    goals = [(3.0, 0.0), (3.0, 2.0), (0.0, 2.0)]
    people = town(
        f"pose: [0, 0, 0], goals: {[list(goal) for goal in goals]}", keys="goal_radius: 0.2"
    )

    path = walk(people, 25.0)[:, 0]

    visited: List[int] = []
    for point in path:
        near = [i for i, goal in enumerate(goals) if math.dist(point, goal) <= 0.2]
        if near and visited[-1:] != near:
            visited += near
    assert visited[:7] == [0, 1, 2, 0, 1, 2, 0]


def test_who_has_one_goal_stays_there(town):
    people = town("pose: [0, 0, 0], goals: [[3, 1]]")

    people.run(12.0)
    arrived = position(people)
    people.run(5.0)

    assert arrived == pytest.approx((3.0, 1.0), abs=0.03)
    assert position(people) == pytest.approx((3.0, 1.0), abs=0.03)


def test_people_face_where_they_go_and_turn_no_faster_than_half_a_turn_a_second(town):
    people = town("pose: [0, 0, -1.5], goals: [[-9, 0], [9, 0]]", keys=CALM)
    headings = []

    for _ in range(100):
        headings.append(people.run(0.02).model("people_0").pose.yaw)

    turns = [math.remainder(b - a, math.tau) for a, b in zip(headings, headings[1:])]
    assert max(map(abs, turns)) == pytest.approx(math.pi * 0.02, rel=1e-3)
    assert math.remainder(headings[-1] - math.pi, math.tau) == pytest.approx(0.0, abs=1e-3)


def test_people_have_their_own_speeds_and_those_of_their_crowd(town):
    people = town(
        "pose: [0, 0, 0], goals: [[100, 0]]",
        "pose: [0, 3, 0], goals: [[100, 3]], speed: 2",
        keys="speed: 0.8, force: {noise: 0}",
    ).run(5.0)

    assert velocity(people, "people_0") == pytest.approx((0.8, 0.0), abs=1e-3)
    assert velocity(people, "people_1") == pytest.approx((2.0, 0.0), abs=1e-3)


def test_noise_makes_people_sway_on_their_way(town):
    people = town("pose: [0, 0, 0], goals: [[1000, 0], [0, 0]]", keys="force: {noise: 0.1}")
    people.run(5.0)

    sideways = np.array([velocity(people.run(UPDATE))[1] for _ in range(4000)])

    # Values correlate over tau: some 4000 * 0.05 / (2 * 0.5) are independent, 5 % each way.
    assert sideways.std() == pytest.approx(0.1, rel=0.2)
    assert abs(sideways.mean()) < 0.03


# Each other


@pytest.mark.parametrize(("side", "sign"), [("right", -1.0), ("left", 1.0)])
def test_two_who_walk_towards_each_other_pass_on_the_preferred_side(town, side, sign):
    keys = f"force: {{noise: 0, side: {side}}}"
    people = town(*TOWARDS_EACH_OTHER, keys=keys)

    path = walk(people, 7.0, "people_0", "people_1")

    apart = np.linalg.norm(path[:, 0] - path[:, 1], axis=1)
    assert apart.min() > 2 * RADIUS + 0.05
    assert path[apart.argmin(), 0, 1] * sign > RADIUS
    assert path[apart.argmin(), 1, 1] * sign < -RADIUS
    # 8 m at 1.34 m/s, and some seconds to speed up and to pass
    assert path[-1, 0, 0] > 3.7
    assert path[-1, 1, 0] < -3.7


@pytest.mark.parametrize("seed", range(5))
def test_whatever_the_chance_the_two_do_not_touch(town, seed):
    people = town(*TOWARDS_EACH_OTHER, seed=seed)

    path = walk(people, 8.0, "people_0", "people_1")

    assert np.linalg.norm(path[:, 0] - path[:, 1], axis=1).min() > 2 * RADIUS
    assert path[-1, 0, 0] > 3.7
    assert path[-1, 1, 0] < -3.7


def test_twenty_who_cross_a_square_all_at_once_get_there(town):
    angles = [math.tau * i / 20 for i in range(20)]
    spots = [(5 * math.cos(a), 5 * math.sin(a)) for a in angles]
    people = town(*(f"pose: [{x}, {y}, 0], goals: [[{-x}, {-y}]]" for x, y in spots))
    names = [f"people_{i}" for i in range(20)]

    path = walk(people, 30.0, *names)

    offsets = path[:, :, np.newaxis] - path[:, np.newaxis]
    apart = np.linalg.norm(offsets, axis=-1) + np.where(np.eye(20, dtype=bool), np.inf, 0.0)
    assert apart.min() > 2 * RADIUS - 0.02  # bodies are hard
    for (x, y), arrived in zip(spots, path[-1]):
        assert arrived == pytest.approx((-x, -y), abs=0.1)


def test_two_crowds_give_way_to_each_other(town, files):
    people = town(TOWARDS_EACH_OTHER[0], keys=CALM)
    text = (files.folder / "world.yaml").read_text()
    second = (
        f"  - {{type: Crowd, name: others, {CALM}, pedestrians: [{{{TOWARDS_EACH_OTHER[1]}}}]}}\n"
    )
    path = files.write("world.yaml", f"{text}\n{second}")
    people.world = World.from_file(path, loader=files._loader)

    way = walk(people, 7.0, "people_0", "others_0")

    assert np.linalg.norm(way[:, 0] - way[:, 1], axis=1).min() > 2 * RADIUS + 0.05
    assert way[-1, 0, 0] > 3.7
    assert way[-1, 1, 0] < -3.7


def test_two_who_stand_close_move_apart_until_they_feel_at_ease(town):
    keys = "force: {noise: 0, evasion: 0}"
    people = town("pose: [0, 0, 0]", "pose: [0.55, 0, 0]", keys=keys).run(20.0)

    # Each is drawn back to its place, half of what the gap has grown by: A exp(-gap / B) is the
    # driving force way / (2 tau) / tau, where way = (gap - 0.05) / 2.
    gap = math.dist(position(people, "people_0"), position(people, "people_1")) - 2 * RADIUS
    assert 25.0 * math.exp(-gap / 0.08) == pytest.approx((gap - 0.05) / 4 / TAU**2, rel=0.02)
    assert gap > 0.15


def test_however_large_the_force_nobody_runs_faster_than_people_do(town):
    keys = "force: {noise: 0, repulsion: 10000}"
    people = town("pose: [0.25, 0, 0], speed: 1.2", keys=keys, walls=("0 -9 0 9",)).run()

    assert velocity(people) == pytest.approx((1.3 * 1.2, 0.0), abs=1e-5)


# Walls


@pytest.mark.parametrize("radius", [0.2, 0.3])
def test_before_a_wall_they_stop_where_the_wall_repels_as_the_goal_attracts(town, radius):
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


def test_walls_of_other_layers_do_not_count(town):
    people = town("pose: [0, 0, 0], goals: [[9, 0]]", keys="layers: [other]", walls=("2 -9 2 9",))

    people.run(10.0)

    assert position(people) == pytest.approx((9.0, 0.0), abs=0.05)


# Robots


@pytest.mark.parametrize("offset", [0.0, 0.1, -0.1])
def test_a_robot_in_the_way_is_passed_at_a_distance(town, files, offset):
    person = f"pose: [-4, {offset}, 0], goals: [[4, {offset}], [9, 0]]"
    people = town(person, robots=robot(files))

    path = walk(people, 8.0)

    assert least_distance(path, (0.0, 0.0)) > 0.2 + RADIUS + 0.1
    assert path[-1, 0, 0] > 3.7
    assert people.model("robot").pose == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)


def test_of_a_long_robot_its_outline_counts(town, files):
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
def test_what_cannot_be_touched_is_not_avoided(town, files, footprint):
    disc = f"{{type: circle, radius: 0.2, density: 10, {footprint}}}"
    keys = f"layers: [map], {CALM}"
    people = town(
        "pose: [-4, 0, 0], goals: [[4, 0]]", keys=keys, robots=robot(files, footprint=disc)
    )

    path = walk(people, 8.0)

    assert least_distance(path, (0.0, 0.0)) < 0.01


def test_who_stands_makes_room_for_a_robot_and_comes_back(town, files):
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


def test_a_heavy_robot_pushes_who_does_not_make_room(town, files):
    tank = "{type: circle, radius: 0.2, density: 100000}"
    robots = robot(files, DRIVE, footprint=tank)
    people = town("pose: [1, 0, 0]", keys=BLIND, robots=robots).drive(0.5).run(4.0)

    assert people.model("robot").pose.x == pytest.approx(2.0, abs=0.05)
    assert position(people)[0] == pytest.approx(people.model("robot").pose.x + 0.45, abs=0.03)


def test_who_walks_pushes_a_light_box_along(town, files):
    people = town("pose: [-2, 0, 0], goals: [[9, 0]]", keys=BLIND, robots=robot(files)).run(4.0)

    assert position(people)[0] > 1.0
    assert people.model("robot").pose.x == pytest.approx(position(people)[0] + 0.45, abs=0.1)


def test_a_person_weighs_80_kg_whatever_its_size(town):
    people = town("pose: [0, 0, 0]", "pose: [2, 0, 0], radius: 0.35, legs: true")

    masses = [people.model(f"people_{i}").base.physics_body.mass for i in range(2)]

    assert masses == pytest.approx([80.0, 80.0], rel=1e-5)


# Before a laser


def seen(town: Any) -> List[List[Tuple[float, float]]]:
    """What the robot's laser sees, beam by beam (angle, range), cut where it sees nothing."""
    scan = town.run().last("/scan")
    clusters: List[List[Tuple[float, float]]] = [[]]
    for index, distance in enumerate(scan.ranges):
        if math.isinf(distance):
            clusters.append([])
        else:
            clusters[-1].append((scan.angle_min + index * scan.angle_increment, distance))
    return [cluster for cluster in clusters if cluster]


def distance_to_disc(x: float, y: float, radius: float, angle: float) -> float:
    """From the origin along an angle."""
    along = x * math.cos(angle) + y * math.sin(angle)
    across = x * math.sin(angle) - y * math.cos(angle)
    return along - math.sqrt(max(0.0, radius**2 - across**2))


def test_a_laser_sees_a_person_as_a_disc(town, files):
    people = town("pose: [2, 0.1, 0]", robots=robot(files, LASER))

    (disc,) = seen(people)

    bearing, half_width = math.atan2(0.1, 2.0), math.asin(RADIUS / math.hypot(2.0, 0.1))
    assert (disc[0][0], disc[-1][0]) == pytest.approx(
        (bearing - half_width, bearing + half_width), abs=1e-3
    )
    for angle, distance in disc[2:-2]:
        assert distance == pytest.approx(distance_to_disc(2.0, 0.1, RADIUS, angle), abs=1e-3)


@pytest.mark.parametrize(
    ("yaw", "radius", "legs"),
    [
        pytest.param(0.0, 0.25, [(2.0, -0.1), (2.0, 0.1)], id="facing away"),
        pytest.param(math.pi / 4, 0.25, [(2.0707, -0.0707), (1.9293, 0.0707)], id="aslant"),
        pytest.param(0.0, 0.3, [(2.0, -0.12), (2.0, 0.12)], id="large"),
    ],
)
def test_a_laser_sees_a_person_with_legs_as_two_small_discs(town, files, yaw, radius, legs):
    person = f"pose: [2, 0, {yaw}], legs: true, radius: {radius}"
    people = town(person, robots=robot(files, LASER))

    clusters = seen(people)

    assert len(clusters) == 2
    for cluster, (x, y) in zip(clusters, legs):
        for angle, distance in cluster[2:-2]:
            expected = distance_to_disc(x, y, 0.28 * radius, angle)
            assert distance == pytest.approx(expected, abs=1e-3)
        middle = (cluster[0][0] + cluster[-1][0]) / 2
        assert middle == pytest.approx(math.atan2(y, x), abs=1e-3)


def test_feet_stand_still_in_turn_and_steps_are_as_long_as_people_make_them(town):
    people = town("pose: [0, 0, 0], goals: [[100, 0], [0, 0]], legs: true", keys=CALM).run(4.0)
    legs = [people.model("people_0").bodies[name] for name in ("left_leg", "right_leg")]

    path = np.array([[leg.pose[:2] for leg in legs] for _ in range(600) if people.run()])

    # step / (steps per second) = 0.384 m s at any speed, so step^2 = 0.384 speed
    step = math.sqrt(0.384 * SPEED)
    speeds = np.diff(path[..., 0], axis=0) / 0.005
    is_still = np.abs(speeds) < 0.05
    assert is_still.any(axis=1).mean() > 0.8
    assert not is_still.all(axis=1).any()
    for foot in range(2):
        assert speeds[:, foot].max() == pytest.approx(2 * SPEED, rel=0.02)
        stands = np.unique(np.round(path[1:, foot, 0][is_still[:, foot]], 1))
        places = stands[np.insert(np.diff(stands) > 0.2, 0, True)]
        assert np.diff(places) == pytest.approx(np.full(len(places) - 1, 2 * step), abs=0.11)
    assert path[:, 0, 1] == pytest.approx(np.full(600, 0.1), abs=2e-3)
    assert path[:, 1, 1] == pytest.approx(np.full(600, -0.1), abs=2e-3)


def test_legs_come_along_wherever_the_body_goes_and_end_abreast(town):
    people = town("pose: [0, 0, 0], goals: [[3, 1]], legs: true")

    for _ in range(2000):
        people.run()
        x, y = position(people)
        for name in ("left_leg", "right_leg"):
            assert math.dist((x, y), people.model("people_0").bodies[name].pose[:2]) < 0.5
    body = people.model("people_0").pose

    for name, side in (("left_leg", 0.1), ("right_leg", -0.1)):
        foot = people.model("people_0").bodies[name].pose
        assert foot[:2] == pytest.approx(body.apply(0.0, side), abs=0.03)


# Models among models


def test_people_are_models_named_after_their_crowd_or_themselves(town):
    people = town("pose: [1, 2, 0.5]", "pose: [2, 3, 0], name: anna, legs: true", "pose: [5, 5, 0]")

    assert list(people.world.models) == ["people_0", "anna", "people_2"]
    assert people.model("people_0").pose == pytest.approx((1.0, 2.0, 0.5))
    assert list(people.model("people_0").bodies) == ["body"]
    assert list(people.model("anna").bodies) == ["body", "left_leg", "right_leg"]


def test_who_is_deleted_leaves_the_crowd_and_the_others_go_on(town, caplog):
    people = town(*TOWARDS_EACH_OTHER, "pose: [0, 5, 0], goals: [[9, 5]]").run(1.0)
    bodies = people.world.physics.body_count

    people.world.delete_model("people_1")
    people.run(6.0)

    assert list(people.world.models) == ["people_0", "people_2"]
    assert people.world.physics.body_count == bodies - 1
    assert position(people)[0] > 3.7
    assert position(people, "people_2")[0] > 6.0
    assert len(people.last("/people/poses").poses) == 2
    assert not [r for r in caplog.records if r.levelno >= logging.WARNING]


def test_a_model_that_takes_a_name_over_is_not_one_of_them(town, files):
    people = town("pose: [0, 0, 0], goals: [[9, 0]]").run(0.5)

    people.world.delete_model("people_0")
    path = files.folder / files.model("guest")
    people.world.spawn_model(path, "people_0", "", Pose(3.0, 0.0, 0.0))
    people.run(2.0)

    assert position(people) == pytest.approx((3.0, 0.0), abs=1e-6)
    assert people.last("/people/poses").poses == []


def test_a_model_that_has_taken_a_name_over_stays_when_the_crowd_goes(town, files):
    people = town("pose: [0, 0, 0]").run()

    people.world.delete_model("people_0")
    path = files.folder / files.model("guest")
    people.world.spawn_model(path, "people_0", "", Pose(3.0, 0.0, 0.0))
    people.world.close()

    assert list(people.world.models) == ["people_0"]


def test_who_is_moved_walks_on_from_there(town):
    people = town("pose: [0, 0, 0], goals: [[9, 0]], legs: true").run(1.0)

    people.world.move_model("people_0", Pose(9.0, 5.0, 2.0))
    people.run(0.1)
    assert position(people) == pytest.approx((9.0, 5.0), abs=0.05)
    people.run(8.0)

    assert position(people) == pytest.approx((9.0, 0.0), abs=0.05)


def test_people_go_when_their_crowd_fails(town, monkeypatch, caplog):
    people = town("pose: [0, 0, 0], goals: [[9, 0]]").run(0.5)

    def fail(*_: Any) -> None:
        raise RuntimeError("no luck")

    monkeypatch.setattr("flatland_plugins.pedestrian.Pedestrian.walk", fail)
    people.run(0.1)

    assert people.world.models == {}
    assert "failed in before_physics_step" in caplog.text


def test_a_crowd_comes_wholly_or_not_at_all(town, monkeypatch):
    worlds = []

    def add_two(world: World, entry: Any) -> Any:
        worlds.append(world)
        if len(worlds) > 2:
            raise FlatlandError("no room for three")
        return add_model(world, entry)

    add_model = World.add_model
    monkeypatch.setattr(World, "add_model", add_two)

    with pytest.raises(FlatlandError, match="no room for three"):
        town("pose: [0, 0, 0]", "pose: [2, 0, 0], legs: true", "pose: [4, 0, 0]")

    assert worlds[0].models == {}
    assert worlds[0].physics.body_count == 0
    assert worlds[0].transport.topics == set()


# Chance


def test_equal_seeds_give_equal_runs(town):
    def run(seed: int) -> List[Any]:
        people = town(*TOWARDS_EACH_OTHER, seed=seed)
        return walk(people, 5.0, "people_0", "people_1").tolist()

    assert run(1) == run(1)
    assert run(1) != run(2)


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
