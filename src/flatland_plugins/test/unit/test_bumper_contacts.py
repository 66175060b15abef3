"""Bumper: colliding bodies, contact points and directions; and excluded bodies."""

import math

import pytest
from bumping import BOX, BUMPER, DISC, RADIUS, SKIN, names, now, press, record, throw, vectors, wall

from flatland_server.geometry import Pose

# Colliding bodies and contact points


@pytest.mark.parametrize("heading", [0.0, 0.7, math.pi / 2, -3.0])
def test_at_a_wall_the_normal_points_into_the_wall(files, heading):
    across = Pose(0.0, 0.0, heading)
    (x1, y1), (x2, y2) = across.apply(1.0, -3.0), across.apply(1.0, 3.0)
    robot = files.robot(BUMPER, layers=wall(files, f"{x1} {y1} {x2} {y2}"))

    throw(robot, math.cos(heading), math.sin(heading)).run(1.0)

    [collision] = now(robot)
    assert names(collision) == ("robot", "base", "walls", "walls")
    [point], [normal] = vectors(collision.contact_positions), vectors(collision.contact_normals)
    assert point == pytest.approx(across.apply(1.0, 0.0), abs=SKIN)
    assert normal == pytest.approx((math.cos(heading), math.sin(heading)), abs=1e-3)
    assert len(collision.magnitude_forces) == 1


@pytest.mark.parametrize("mine", [DISC, BOX])
@pytest.mark.parametrize("others", [DISC, BOX])
@pytest.mark.parametrize("is_first", [True, False])
def test_normals_go_from_the_robot_to_the_other(files, mine, others, is_first):
    # Box2D sorts the two by their shapes, and shapes of a kind by their age.
    obstacle = files.model("obstacle", footprint=others, body="type: static,")
    robot_file = files.model("robot", BUMPER, footprint=mine)
    robot = {"robot": f"model: {robot_file}, pose: [3, 1, 0]"}
    post = {"post": f"model: {obstacle}, pose: [3, 2, 0]"}
    world = files.load_models({**robot, **post} if is_first else {**post, **robot})

    throw(world, 0.0, 1.0).run(1.0)

    [collision] = now(world)
    assert names(collision) == ("robot", "base", "post", "base")
    reach = 0.25 if others == BOX else 0.2
    for x, y in vectors(collision.contact_positions):
        assert y == pytest.approx(2.0 - reach, abs=SKIN)
        assert x == pytest.approx(3.0, abs=0.25 + SKIN if mine == others == BOX else 1e-3)
    for normal in vectors(collision.contact_normals):
        assert normal == pytest.approx((0.0, 1.0), abs=1e-3)


def test_bodies_and_layers_are_named_as_in_their_files(files):
    disc = "footprints: [{type: circle, radius: 0.1, density: 1}]"
    weld = "[{name: base, anchor: [0.5, 0]}, {name: fender, anchor: [0, 0]}]"
    two_bodies = f"""
        bodies: [{{name: base, {disc}}}, {{name: fender, pose: [0.5, 0, 0], {disc}}}]
        joints: [{{type: weld, name: arm, bodies: {weld}}}]
        plugins: [{{{BUMPER}}}]
        """
    files.write("long.model.yaml", two_bodies)
    leaf = f"bodies: [{{name: leaf, type: static, footprints: [{DISC}]}}]"
    files.write("door.model.yaml", leaf)
    world = files.load_models(
        {
            "robot": "model: long.model.yaml, pose: [0.36, 0, 0], namespace: robot1",
            "door": "model: door.model.yaml, pose: [0.36, 0.35, 0]",
        },
        wall(files, name="[bricks, stones]"),
    )

    throw(world, 1.0, 1.0).run(0.5)

    reported = {names(each) for each in now(world, "/robot1/collisions")}
    assert reported == {("robot", "base", "door", "leaf"), ("robot", "fender", "bricks", "bricks")}


def test_in_a_corner_each_wall_is_a_collision_of_its_own(files):
    walls = ("1 -3 1 1", "1 1 -3 1")
    robot = files.robot(BUMPER, pose="[0.75, 0.75, 0]", layers=wall(files, *walls))

    press(robot, (3.0, 2.0), 1.0)

    # Each wall bears its part of the push.
    east, north = sorted(now(robot), key=lambda collision: collision.contact_normals[0].y)
    assert vectors(east.contact_normals) == [pytest.approx((1.0, 0.0), abs=1e-3)]
    assert vectors(north.contact_normals) == [pytest.approx((0.0, 1.0), abs=1e-3)]
    assert east.magnitude_forces == [pytest.approx(3.0, rel=1e-2)]
    assert north.magnitude_forces == [pytest.approx(2.0, rel=1e-2)]


SENSOR = f"{{type: circle, radius: {RADIUS}, density: 10, sensor: true}}"


def past_a_post(files, mine: str, others: str, bumper: str = BUMPER):
    """A robot that is about to drive through a post at 1 m; one of them or both are sensors."""
    post = files.model("post", footprint=others, body="type: static,")
    robot = files.robot(bumper, footprint=mine, others={"post": f"model: {post}, pose: [1, 0, 0]"})
    return throw(robot, 1.0)


@pytest.mark.parametrize(("mine", "others"), [(SENSOR, DISC), (DISC, SENSOR), (SENSOR, SENSOR)])
def test_contacts_with_a_sensor_are_reported_without_points(files, mine, others):
    robot = past_a_post(files, mine, others)

    messages = robot.record("/collisions", 2.0)

    assert robot.model().pose.x == pytest.approx(2.0, abs=1e-3)  # it went through
    touching = [message for message in messages if message.collisions]
    begin, end = (touching[i].header.stamp.to_sec() for i in (0, -1))
    assert (begin, end) == pytest.approx((1.0 - 2 * RADIUS, 1.0 + 2 * RADIUS), abs=0.011)
    assert len(touching) == round((end - begin) / 0.005) + 1
    for message in touching:
        [collision] = message.collisions
        assert names(collision) == ("robot", "base", "post", "base")
        lists = collision.magnitude_forces, collision.contact_positions, collision.contact_normals
        assert lists == ([], [], [])


def test_a_body_resting_on_a_sensor_is_reported_until_it_leaves(files):
    robot = past_a_post(files, DISC, SENSOR).run(1.0)
    throw(robot, 0.0).run(2.0)
    assert not robot.model().base.physics_body.awake
    assert [names(each)[2] for each in now(robot)] == ["post"]

    robot.world.delete_model("post")
    robot.run()

    assert now(robot) == []


def test_a_sensor_of_an_ignored_body_is_not_reported(files):
    assert record(past_a_post(files, SENSOR, DISC, f"{BUMPER}, exclude: [base]"), 2.0) == []


def test_a_sensor_footprint_does_not_hide_points_of_a_solid_one(files):
    ring = f"{{type: circle, radius: {2 * RADIUS}, density: 0, sensor: true}}"
    robot = past_a_post(files, f"{DISC}, {ring}", DISC)

    press(robot, (1.0, 0.0), 1.5)

    counts = sorted(len(each.contact_positions) for each in now(robot))
    assert counts == [0, 1]


# Bodies to ignore


def clapper(files, *plugins: str):
    """A robot with two arms that fall together: joined, they may collide with each other."""
    lines = "".join(f"\n          - {{{plugin}}}" for plugin in plugins)
    text = f"""
        bodies:
          - {{name: base, type: static, pose: [5, 5, 0],
             footprints: [{{type: circle, radius: 0.1, density: 1}}]}}
          - {{name: left, pose: [-0.5, 0, 0], footprints: [{DISC}]}}
          - {{name: right, pose: [0.5, 0, 0], footprints: [{DISC}]}}
        plugins:{lines}
        """
    files.write("clapper.model.yaml", text)
    world = files.load_models({"robot": "model: clapper.model.yaml"})
    world.model().get_body("left").physics_body.velocity = (1.0, 0.0, 0.0)
    world.model().get_body("right").physics_body.velocity = (-1.0, 0.0, 0.0)
    return world


def test_bodies_of_one_model_collide_with_each_other(files):
    [collision] = now(clapper(files, BUMPER).run(1.0))

    assert collision.entity_A == collision.entity_B == "robot"
    a_to_b = 1.0 if collision.body_A == "left" else -1.0
    assert {collision.body_A, collision.body_B} == {"left", "right"}
    assert vectors(collision.contact_normals) == [pytest.approx((a_to_b, 0.0), abs=1e-3)]


@pytest.mark.parametrize(
    ("exclude", "is_told"),
    [("[]", True), ("[base]", True), ("[left]", False), ("[right]", False), ("right", False)],
)
def test_exclude_hides_collisions_with_the_body_on_either_side(files, exclude: str, is_told: bool):
    world = clapper(files, f"{BUMPER}, exclude: {exclude}")

    assert bool(record(world, 1.0)) == is_told


def test_exclude_hides_only_contacts_of_the_excluded_body(files):
    text = """
        bodies:
          - {name: base, footprints: [{type: circle, radius: 0.1, density: 1}]}
          - {name: wheel, pose: [0, 0.5, 0], footprints: [{type: circle, radius: 0.1, density: 1}]}
        plugins:
          - {type: Bumper, name: all, topic: all}
          - {type: Bumper, name: some, topic: some, exclude: [wheel]}
        """
    files.write("robot.model.yaml", text)
    world = files.load_models({"robot": "model: robot.model.yaml"}, wall(files))
    for body in world.model().bodies.values():
        body.physics_body.velocity = (1.0, 0.0, 0.0)

    world.run(1.5)

    assert {each.body_A for each in now(world, "/all")} == {"base", "wheel"}
    assert {each.body_A for each in now(world, "/some")} == {"base"}
