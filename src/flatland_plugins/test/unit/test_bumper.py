"""Bumper: who collides with whom, where, in which direction and how hard; and when it says so."""

import math
from typing import Any, List, Tuple

import pytest
from flatland_msgs.msg import Collision, Collisions

from flatland_server.geometry import Pose
from flatland_server.model_plugin import ModelPlugin
from flatland_server.plugin_loader import PluginDeclaration, PluginLoader, discover

BUMPER = "type: Bumper, name: bumper"
STEP = 0.005
RADIUS, MASS = 0.2, 0.04 * math.pi * 10  # of the disc of conftest.py
CORNERS = "[[-0.25, -0.25], [0.25, -0.25], [0.25, 0.25], [-0.25, 0.25]]"
BOX = f"{{type: polygon, points: {CORNERS}, density: 4}}"  # 1 kg
DISC = f"{{type: circle, radius: {RADIUS}, density: 10}}"

SKIN = 0.02
"""How exactly Box2D knows where two shapes touch [m]: each has a skin of up to 1 cm."""


class Ghost(ModelPlugin):
    """Lets its model pass through everything from a moment on."""

    def on_initialize(self, config):
        self._since = config.get_float("since", 0.0)
        self._now = 0.0

    def before_physics_step(self, timekeeper):
        self._now = timekeeper.seconds

    def pre_solve(self, contact, old_manifold):
        if self._now >= self._since:
            contact.set_enabled(False)


@pytest.fixture(scope="module")
def loader() -> PluginLoader:
    """The plugins of this workspace, and the one of this file."""
    return PluginLoader([*discover(), PluginDeclaration("Ghost", "test", f"{__name__}.Ghost")])


def wall(files, *segments: str, name: str = "walls") -> Tuple[str, ...]:
    """A layer of walls, by default one across the x axis at 1 m."""
    return (f"name: {name}, map: {files.walls('wall', *(segments or ['1 -3 1 3']))}",)


def throw(robot, vx: float, vy: float = 0.0, name: str = "robot"):
    """Gives a model a velocity, from now on."""
    robot.model(name).base.physics_body.velocity = (vx, vy, 0.0)
    return robot


def press(robot, force: Tuple[float, float], seconds: float, at: Tuple[float, float] = (0.0, 0.0)):
    """Pushes the robot all the time, at a point of its body."""
    body = robot.model().base.physics_body
    for _ in range(round(seconds / STEP)):
        body.apply_force(force, body.world_point(at))
        robot.run()
    return robot


def record(robot, seconds: float, topic: str = "/collisions") -> List[Collision]:
    """The collisions that are told of while time passes, one after the other."""
    return [each for message in robot.record(topic, seconds) for each in message.collisions]


def impulse(collisions: List[Collision]) -> float:
    """All that was given to the robot, at all points and in all steps [N s]."""
    return sum(sum(each.magnitude_forces) for each in collisions) * STEP


def now(robot, topic: str = "/collisions") -> List[Collision]:
    message = robot.last(topic)
    assert isinstance(message, Collisions)
    return list(message.collisions)


def vectors(points: Any) -> List[Tuple[float, float]]:
    return [(point.x, point.y) for point in points]


def names(collision: Collision) -> Tuple[str, str, str, str]:
    return collision.entity_A, collision.body_A, collision.entity_B, collision.body_B


# What collides, and where


@pytest.mark.parametrize("heading", [0.0, 0.7, math.pi / 2, -3.0])
def test_at_a_wall_it_tells_where_and_that_the_normal_goes_into_the_wall(files, heading):
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
def test_normals_go_from_the_robot_to_the_other_whichever_box2d_calls_the_first(
    files, mine: str, others: str, is_first: bool
):
    # Box2D sorts the two by their shapes, and shapes of a kind by their age.
    obstacle = files.model("obstacle", footprint=others, body="type: static,")
    robot_file = files.model("robot", BUMPER, footprint=mine)
    robot = {"robot": f"model: {robot_file}, pose: [3, 1, 0]"}
    post = {"post": f"model: {obstacle}, pose: [3, 2, 0]"}
    world = files.load({**robot, **post} if is_first else {**post, **robot})

    throw(world, 0.0, 1.0).run(1.0)

    [collision] = now(world)
    assert names(collision) == ("robot", "base", "post", "base")
    reach = 0.25 if others == BOX else 0.2
    for x, y in vectors(collision.contact_positions):
        assert y == pytest.approx(2.0 - reach, abs=SKIN)
        assert x == pytest.approx(3.0, abs=0.25 + SKIN if mine == others == BOX else 1e-3)
    for normal in vectors(collision.contact_normals):
        assert normal == pytest.approx((0.0, 1.0), abs=1e-3)


@pytest.mark.parametrize("is_first", [True, False])
def test_two_robots_that_collide_tell_of_the_same_from_either_side(files, is_first):
    robot_file = files.model("robot", BUMPER)
    left = {"left": f"model: {robot_file}, pose: [-0.3, 0, 0], namespace: l"}
    right = {"right": f"model: {robot_file}, pose: [0.3, 0, 0], namespace: r"}
    world = files.load({**left, **right} if is_first else {**right, **left})
    throw(world, 1.0, name="left")

    seen = {topic: [] for topic in ("/l/collisions", "/r/collisions")}
    for _ in range(100):
        world.run()
        for topic in seen:
            seen[topic].append(now(world, topic))

    # Without restitution both go on at half the speed, side by side: one gives, one takes m v / 2.
    for ours, theirs in zip(*seen.values()):
        for mine, other in zip(ours, theirs):
            assert names(mine) == ("left", "base", "right", "base")
            assert names(other) == ("right", "base", "left", "base")
            assert vectors(mine.contact_normals) == [pytest.approx((1.0, 0.0), abs=1e-3)]
            assert vectors(other.contact_normals) == [pytest.approx((-1.0, 0.0), abs=1e-3)]
            assert mine.contact_positions == other.contact_positions
            assert mine.magnitude_forces == other.magnitude_forces
    assert [len(each) for each in seen["/l/collisions"]] == [len(e) for e in seen["/r/collisions"]]
    total = impulse([each for step in seen["/l/collisions"] for each in step])
    assert total == pytest.approx(MASS * 0.5, rel=1e-3)


def test_bodies_and_layers_are_named_as_in_their_files(files):
    two_bodies = """
        bodies:
          - {name: base, footprints: [{type: circle, radius: 0.1, density: 1}]}
          - {name: fender, pose: [0.5, 0, 0],
             footprints: [{type: circle, radius: 0.1, density: 1}]}
        joints:
          - {type: weld, name: arm, bodies: [{name: base, anchor: [0.5, 0]},
             {name: fender, anchor: [0, 0]}]}
        plugins: [{type: Bumper, name: bumper}]
        """
    files.write("long.model.yaml", two_bodies)
    leaf = f"bodies: [{{name: leaf, type: static, footprints: [{DISC}]}}]"
    files.write("door.model.yaml", leaf)
    world = files.load(
        {
            "robot": "model: long.model.yaml, pose: [0.36, 0, 0], namespace: robot1",
            "door": "model: door.model.yaml, pose: [0.36, 0.35, 0]",
        },
        wall(files, name="[bricks, stones]"),
    )

    throw(world, 1.0, 1.0).run(0.5)

    told = {names(each) for each in now(world, "/robot1/collisions")}
    assert told == {("robot", "base", "door", "leaf"), ("robot", "fender", "bricks", "bricks")}


def test_flat_faces_touch_at_two_points(files):
    robot = throw(files.robot(BUMPER, footprint=BOX, layers=wall(files)), 1.0)

    press(robot, (2.0, 0.0), 1.0)

    [collision] = now(robot)
    points = sorted(vectors(collision.contact_positions), key=lambda point: point[1])
    assert points[0] == pytest.approx((1.0, -0.25), abs=SKIN)
    assert points[1] == pytest.approx((1.0, 0.25), abs=SKIN)
    assert vectors(collision.contact_normals) == [pytest.approx((1.0, 0.0), abs=1e-3)] * 2
    assert len(collision.magnitude_forces) == 2


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


@pytest.mark.parametrize("is_sensor", ["mine", "the other's"])
def test_what_a_sensor_notices_is_no_collision(files, is_sensor):
    sensor = f"{{type: circle, radius: {RADIUS}, density: 10, sensor: true}}"
    mine, others = (sensor, DISC) if is_sensor == "mine" else (DISC, sensor)
    post = files.model("post", footprint=others, body="type: static,")
    robot = files.robot(BUMPER, footprint=mine, others={"post": f"model: {post}, pose: [1, 0, 0]"})

    assert record(throw(robot, 1.0), 2.0) == []
    assert robot.model().pose.x == pytest.approx(2.0, abs=1e-3)  # it went through


def test_footprints_of_other_layers_do_not_collide(files):
    footprint = f"{{type: circle, radius: {RADIUS}, density: 10, layers: [other]}}"
    robot = files.robot(BUMPER, footprint=footprint, layers=(*wall(files), "name: other"))

    assert record(throw(robot, 1.0), 2.0) == []


# Forces


@pytest.mark.parametrize("speed", [0.5, 2.0, 10.0, 60.0])
@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
def test_the_forces_of_a_head_on_hit_add_up_to_the_change_of_momentum(files, speed, restitution):
    ball = f"{{type: circle, radius: {RADIUS}, density: 10, restitution: {restitution}}}"
    robot = throw(files.robot(BUMPER, footprint=ball, layers=wall(files)), speed)
    bounce = restitution if speed > 1.0 else 0.0  # Box2D lets nothing bounce below 1 m/s

    given = impulse(record(robot, 2.0))

    assert robot.model().base.physics_body.velocity[0] == pytest.approx(-bounce * speed, rel=1e-4)
    assert given == pytest.approx(MASS * speed * (1.0 + bounce), rel=1e-4)


@pytest.mark.parametrize("step", [0.001, 0.005, 0.02])
def test_the_same_hit_in_longer_steps_is_a_smaller_force(files, step):
    robot = throw(files.robot(BUMPER, layers=wall(files)), 2.0)
    robot.timekeeper = type(robot.timekeeper)(step)

    forces = [sum(each.magnitude_forces) for each in record(robot, 1.0)]

    assert max(forces) == pytest.approx(MASS * 2.0 / step, rel=1e-3)


def test_an_edge_that_hits_aslant_gives_what_it_takes_from_the_motion(files):
    robot = files.robot(BUMPER, footprint=BOX, pose="[0, 0, 0.3]", layers=wall(files))

    given = impulse(record(throw(robot, 10.0), 2.0))

    # 1 kg; the wall pushes along x alone, whatever turn the box takes.
    change = 10.0 - robot.model().base.physics_body.velocity[0]
    assert given == pytest.approx(change, rel=1e-4)


def test_a_hit_in_the_midst_of_a_step_takes_nothing_from_the_other_forces_of_the_step(files):
    # Pressed down on a floor, it flies along it into a wall: Box2D solves that step in two parts.
    robot = files.robot(BUMPER, pose="[0.6, 0.2, 0]", layers=wall(files, "-3 0 3 0", "1 -3 1 3"))
    press(robot, (0.0, -3.0), 0.5)

    press(throw(robot, 60.0), (0.0, -3.0), STEP)

    floor, ahead = sorted(now(robot), key=lambda collision: collision.contact_normals[0].x)
    assert vectors(floor.contact_normals) == [pytest.approx((0.0, -1.0), abs=1e-3)]
    assert floor.magnitude_forces == [pytest.approx(3.0, rel=1e-2)]
    assert vectors(ahead.contact_normals) == [pytest.approx((1.0, 0.0), abs=1e-3)]
    assert impulse([ahead]) == pytest.approx(MASS * 60.0, rel=1e-3)


def test_a_robot_that_is_pushed_against_a_wall_feels_the_push(files):
    robot = press(files.robot(BUMPER, pose="[0.79, 0, 0]", layers=wall(files)), (3.0, 0.0), 1.0)

    [collision] = now(robot)

    assert collision.magnitude_forces == [pytest.approx(3.0, rel=1e-3)]
    assert robot.model().base.physics_body.velocity == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)


@pytest.mark.parametrize("height", [0.0, 0.1, -0.2])
def test_two_points_share_a_push_by_the_lever_rule(files, height):
    robot = files.robot(BUMPER, footprint=BOX, pose="[0.74, 0, 0]", layers=wall(files))

    press(robot, (4.0, 0.0), 2.0, at=(0.0, height))

    # f1 + f2 = F and (f1 - f2) a = F h, with the points at +-a.
    [collision] = now(robot)
    for (_, y), force in zip(vectors(collision.contact_positions), collision.magnitude_forces):
        share = 0.5 * (1.0 + math.copysign(height / 0.25, height * y))
        assert force == pytest.approx(4.0 * share, abs=0.1)
    assert sum(collision.magnitude_forces) == pytest.approx(4.0, rel=1e-2)


# From begin to end


def test_a_contact_that_another_plugin_switches_off_is_none(files):
    ghost = "type: Ghost, name: ghost"
    robot = throw(files.robot(BUMPER, ghost, layers=wall(files)), 1.0)

    assert record(robot, 2.0) == []
    assert robot.model().pose.x == pytest.approx(2.0, abs=1e-3)


def test_a_contact_that_is_switched_off_later_is_none_from_then_on(files):
    ghost = "type: Ghost, name: ghost, since: 1.5"
    robot = throw(files.robot(BUMPER, ghost, layers=wall(files)), 1.0)

    press(robot, (1.0, 0.0), 1.5)
    assert len(now(robot)) == 1
    press(robot, (1.0, 0.0), 0.005)
    assert now(robot) == []

    # It goes on without a push, and falls asleep within the wall.
    robot.model().base.physics_body.velocity = (0.0, 0.0, 0.0)
    assert record(robot, 2.0) == []
    assert not robot.model().base.physics_body.awake


def test_what_rests_in_touch_is_told_of_without_any_force(files):
    robot = throw(files.robot(BUMPER, layers=wall(files)), 1.0).run(1.0)
    [touch] = now(robot)

    told = robot.record("/collisions", 2.0)

    assert not robot.model().base.physics_body.awake
    assert len(told) == 400
    for message in told:
        [collision] = message.collisions
        assert collision.magnitude_forces == [pytest.approx(0.0, abs=1e-3)]
        assert names(collision) == names(touch)
        assert collision.contact_positions == touch.contact_positions
        assert collision.contact_normals == touch.contact_normals
    assert told[-1].collisions[0].magnitude_forces == [0.0]


def test_what_rests_feels_the_next_push(files):
    robot = throw(files.robot(BUMPER, layers=wall(files)), 1.0).run(3.0)
    assert not robot.model().base.physics_body.awake

    press(robot, (2.0, 0.0), 0.005)

    [collision] = now(robot)
    assert collision.magnitude_forces == [pytest.approx(2.0, rel=1e-3)]


def test_a_touch_that_ends_within_the_step_is_told_of(files):
    # Off one wall at 60 m/s, it is at the other 0.1 m away after a third of a step.
    walls = ("-0.2 -3 -0.2 3", "0.3 -3 0.3 3")
    robot = files.robot(BUMPER, layers=wall(files, *walls))

    throw(robot, 60.0).run()

    told = {vectors(each.contact_normals)[0][0]: each for each in now(robot)}
    assert set(told) == {-1.0, 1.0}
    assert told[-1.0].magnitude_forces == [0.0]
    assert impulse([told[1.0]]) == pytest.approx(MASS * 60.0, rel=1e-4)
    robot.run()
    assert [vectors(each.contact_normals)[0][0] for each in now(robot)] == [1.0]


def test_what_comes_apart_collides_no_longer(files):
    robot = throw(files.robot(BUMPER, layers=wall(files)), 1.0).run(1.0)
    assert len(now(robot)) == 1

    throw(robot, -1.0).run(0.05)

    assert now(robot) == []


def test_a_robot_that_is_moved_away_leaves_its_collisions_behind(files):
    robot = throw(files.robot(BUMPER, layers=wall(files)), 1.0).run(3.0)

    robot.world.move_model("robot", Pose(-2.0, 0.0, 0.0))
    robot.run()

    assert now(robot) == []


@pytest.mark.parametrize("seconds", [1.0, 4.0])  # by then all is at rest, and asleep
def test_a_model_that_is_deleted_collides_no_longer(files, seconds):
    post = files.model("post", footprint=BOX, body="type: static,")
    robot = files.robot(BUMPER, others={"post": f"model: {post}, pose: [1, 0, 0]"})
    throw(robot, 1.0).run(seconds)
    assert [names(each)[2] for each in now(robot)] == ["post"]

    robot.world.delete_model("post")
    robot.run()

    assert now(robot) == []


def test_a_robot_can_be_deleted_while_it_collides(files, caplog):
    robot = throw(files.robot(BUMPER, layers=wall(files)), 1.0).run(1.0)
    assert len(now(robot)) == 1

    robot.world.delete_model("robot")
    robot.run(0.1)

    assert robot.transport.topics == set()
    assert caplog.records == []


def test_a_model_is_told_of_that_takes_the_place_of_a_deleted_one(files):
    post = files.model("post", footprint=BOX, body="type: static,")
    robot = files.robot(BUMPER, others={"post": f"model: {post}, pose: [1, 0, 0]"})
    throw(robot, 1.0).run(1.0)

    robot.world.delete_model("post")
    robot.world.spawn_model(files.folder / post, "pillar", "", Pose(1.0, 0.0, 0.0))
    press(robot, (1.0, 0.0), 0.5)

    assert [names(each)[2] for each in now(robot)] == ["pillar"]


# Bodies to ignore


def clapper(files, *plugins: str):
    """A robot whose two arms fall together: joined, they may collide with each other."""
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
    world = files.load({"robot": "model: clapper.model.yaml"})
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
def test_collisions_of_an_ignored_body_are_not_told_on_whichever_side_it_is(
    files, exclude: str, is_told: bool
):
    world = clapper(files, f"{BUMPER}, exclude: {exclude}")

    assert bool(record(world, 1.0)) == is_told


def test_what_an_ignored_body_hits_is_not_told_but_what_the_others_hit(files):
    text = """
        bodies:
          - {name: base, footprints: [{type: circle, radius: 0.1, density: 1}]}
          - {name: wheel, pose: [0, 0.5, 0], footprints: [{type: circle, radius: 0.1, density: 1}]}
        plugins:
          - {type: Bumper, name: all, topic: all}
          - {type: Bumper, name: some, topic: some, exclude: [wheel]}
        """
    files.write("robot.model.yaml", text)
    world = files.load({"robot": "model: robot.model.yaml"}, wall(files))
    for body in world.model().bodies.values():
        body.physics_body.velocity = (1.0, 0.0, 0.0)

    world.run(1.5)

    assert {each.body_A for each in now(world, "/all")} == {"base", "wheel"}
    assert {each.body_A for each in now(world, "/some")} == {"base"}


# When it says so


def test_by_default_it_publishes_at_every_step_colliding_or_not(files):
    robot = throw(files.robot(BUMPER, layers=wall(files)), 1.0)

    messages = robot.record("/collisions", 1.0)

    assert [m.header.stamp.to_nsec() for m in messages] == [5_000_000 * i for i in range(1, 201)]
    touches = [bool(message.collisions) for message in messages]
    first = touches.index(True)
    # 0.8 m at 1 m/s, but for the skin.
    assert messages[first].header.stamp.to_sec() == pytest.approx(0.8, abs=SKIN)
    assert touches == [False] * first + [True] * (200 - first)


def test_all_collisions_are_published_at_once_and_empty_lists_at_the_rate(files):
    robot = throw(files.robot(f"{BUMPER}, update_rate: 10", layers=wall(files)), 1.0)

    messages = robot.record("/collisions", 1.0)
    throw(robot, -1.0)
    messages += robot.record("/collisions", 1.0)

    touching = [m.header.stamp.to_nsec() for m in messages if m.collisions]
    empty = [m.header.stamp.to_nsec() for m in messages if not m.collisions]
    assert touching == list(range(touching[0], touching[-1] + 1, 5_000_000))
    assert len(touching) == pytest.approx(40, abs=5)
    # From the end of the first step on.
    due = [5_000_000 + 100_000_000 * i for i in range(20)]
    assert empty == [time for time in due if not touching[0] <= time <= touching[-1]]


def test_otherwise_it_publishes_at_the_rate_alone_what_collides_just_then(files):
    bumper = f"{BUMPER}, update_rate: 10, publish_all_collisions: false"
    robot = throw(files.robot(bumper, layers=wall(files)), 1.0)

    messages = robot.record("/collisions", 2.0)

    stamps = [message.header.stamp.to_nsec() for message in messages]
    assert stamps == [5_000_000 + 100_000_000 * i for i in range(20)]
    assert [len(message.collisions) for message in messages] == [0] * 8 + [1] * 12


@pytest.mark.parametrize(("publish_all", "is_told"), [("true", True), ("false", False)])
def test_a_collision_between_two_updates_is_told_of_only_with_all(files, publish_all, is_told):
    ball = f"{{type: circle, radius: {RADIUS}, density: 10, restitution: 1}}"
    bumper = f"{BUMPER}, update_rate: 10, publish_all_collisions: {publish_all}"
    robot = files.robot(bumper, footprint=ball, layers=wall(files), pose="[0.65, 0, 0]")

    # At 3 m/s it is at the wall half way between two updates.
    assert bool(record(throw(robot, 3.0), 0.5)) == is_told
    assert robot.model().base.physics_body.velocity[0] == pytest.approx(-3.0, rel=1e-3)


def test_a_rate_that_is_no_multiple_of_the_step_is_kept_on_average(files):
    robot = files.robot(f"{BUMPER}, update_rate: 60")

    assert len(robot.record("/collisions", 5.0)) == 300


def test_the_stamp_is_the_time_after_the_step_as_clock_tells_it(files):
    robot = files.robot(BUMPER).run(0.1)

    message = robot.last("/collisions")

    assert message.header.stamp.to_nsec() == robot.timekeeper.nanoseconds == 100_000_000


# Topics and frames


def test_topic_and_frame_are_the_documented_ones(files):
    robot = files.robot(BUMPER, namespace="robot1").run()

    assert robot.transport.topics == {"/robot1/collisions"}
    assert robot.last("/robot1/collisions").header.frame_id == "map"


@pytest.mark.parametrize(("topic", "resolved"), [("bumps", "/robot1/bumps"), ("/bumps", "/bumps")])
def test_topic_and_frame_can_be_named(files, topic, resolved):
    bumper = f"{BUMPER}, topic: {topic}, world_frame_id: world"
    robot = files.robot(bumper, namespace="robot1").run()

    assert robot.transport.topics == {resolved}
    assert robot.last(resolved).header.frame_id == "world"


def test_nothing_is_published_that_nobody_listens_to(files, deaf_transport):
    robot = files.robot(BUMPER, layers=wall(files), transport=deaf_transport)

    throw(robot, 1.0).run(1.5)

    assert deaf_transport.published == []


def test_who_begins_to_listen_in_the_midst_of_a_collision_hears_of_it(files, deaf_transport):
    robot = throw(files.robot(BUMPER, layers=wall(files), transport=deaf_transport), 1.0).run(1.5)

    deaf_transport.publishers[0].is_watched = True
    press(robot, (2.0, 0.0), 0.005)

    [collision] = now(robot)
    assert collision.magnitude_forces == [pytest.approx(2.0, rel=1e-3)]


@pytest.mark.parametrize(
    "key", ["world_frame_id", "topic", "update_rate", "publish_all_collisions", "exclude"]
)
def test_a_key_without_its_last_letter_is_refused_with_a_suggestion(files, key):
    message = f'plugins[0] "bumper": unknown key "{key[:-1]}" (did you mean "{key}"?)'

    assert files.refusal(f"{BUMPER}, {key[:-1]}: 1") == f"robot.model.yaml:5: {message}"


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        pytest.param(
            "update_rate: 0",
            "plugins[0].update_rate: expected a number above 0, found 0",
            id="rate of zero",
        ),
        pytest.param(
            "publish_all_collisions: sometimes",
            'plugins[0].publish_all_collisions: expected true or false, found "sometimes"',
            id="no flag",
        ),
        pytest.param(
            "exclude: [bas]",
            'plugins[0].exclude: the model has no body "bas" (did you mean "base"?); it has: base',
            id="unknown body",
        ),
        pytest.param(
            "exclude: {base: true}",
            "plugins[0].exclude: expected a text, found a map",
            id="no list",
        ),
    ],
)
def test_a_wrong_configuration_is_refused_at_its_line(files, keys, message):
    assert files.refusal(f"{BUMPER}, {keys}") == f"robot.model.yaml:5: {message}"
