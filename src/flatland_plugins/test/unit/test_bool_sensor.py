"""BoolSensor: contacts that count as a touch, how long one is kept, and when it is published."""

from typing import Any, List, Tuple

import pytest
from std_msgs.msg import Bool

from flatland_plugins.bool_sensor import BoolSensor
from flatland_server.geometry import Pose

SENSOR = "type: BoolSensor, name: sensor"
STEP_NS = 5_000_000
DISC = "{type: circle, radius: 0.2, density: 10}"
AREA = "{type: circle, radius: 0.2, density: 10, sensor: true}"


def with_ball(files, plugin: str = SENSOR, footprint: str = AREA, ball: str = DISC, **options: Any):
    """A robot at the origin, and a ball 1 m before it."""
    entry = f"model: {files.model('ball', footprint=ball)}, pose: [1, 0, 0]"
    return files.robot(plugin, footprint=footprint, others={"ball": entry}, **options)


def move(world, x: float, y: float = 0.0, name: str = "ball"):
    """Puts a model somewhere, at rest."""
    world.world.move_model(name, Pose(x, y, 0.0))
    return world


def said(world, topic: str = "/bool_sensor") -> bool:
    """The value of the sensor's last message."""
    message = world.last(topic)
    assert isinstance(message, Bool)
    return bool(message.data)


def history(world, seconds: float, topic: str = "/bool_sensor") -> List[Tuple[int, bool]]:
    """The times [ns] and values of the sensor's messages."""
    spoken: List[Tuple[int, bool]] = []
    before = world.last(topic)
    for _ in range(round(seconds * 1e9 / STEP_NS)):
        message = world.run().last(topic)
        if message is not before:
            spoken.append((world.timekeeper.nanoseconds, message.data))
            before = message
    return spoken


# Contacts that count


@pytest.mark.parametrize("footprint", [AREA, DISC])
@pytest.mark.parametrize("kind", ["dynamic", "static"])
def test_solid_bodies_and_sensors_notice_what_touches_them(files, footprint, kind):
    ball = files.model("ball", footprint=DISC)
    plate = files.model("plate", SENSOR, footprint=footprint, body=f"type: {kind},")
    world = files.load_models(
        {"plate": f"model: {plate}", "ball": f"model: {ball}, pose: [1, 0, 0]"}
    )

    assert not said(world.run())
    assert said(move(world, 0.3).run())
    assert all(touched for _, touched in history(world, 3.0))
    assert kind == "static" or not world.model("ball").base.physics_body.awake
    assert not said(move(world, 1.0).run())


@pytest.mark.parametrize("footprint", [AREA, DISC])
def test_walls_are_noticed_too(files, footprint):
    robot = files.robot(SENSOR, footprint=footprint, walls=["1 -3 1 3"])

    assert not said(robot.run())
    assert said(move(robot, 0.9, name="robot").run())


def test_a_sensor_footprint_does_not_trigger_the_sensor(files):
    world = with_ball(files, footprint=DISC, ball=AREA)

    assert not said(move(world, 0.1).run())


def gripper(files, *plugins: str):
    """A robot with an area between its arms, and a ball that no part of it touches."""
    lines = "".join(f"\n          - {{{plugin}}}" for plugin in plugins)
    text = f"""
        bodies:
          - {{name: base, footprints: [{DISC}]}}
          - {{name: area, pose: [0.3, 0, 0], footprints: [{AREA}]}}
          - {{name: arm, pose: [0.4, 0, 0], footprints: [{DISC}]}}
        joints:
          - {{type: weld, name: a, bodies: [{{name: base, anchor: [0.3, 0]}},
              {{name: area, anchor: [0, 0]}}], collide_connected: true}}
          - {{type: weld, name: b, bodies: [{{name: base, anchor: [0.4, 0]}},
              {{name: arm, anchor: [0, 0]}}], collide_connected: true}}
        plugins:{lines}
        """
    files.write("gripper.model.yaml", text)
    ball = files.model("ball", footprint="{type: circle, radius: 0.05, density: 1}")
    return files.load_models(
        {"gripper": "model: gripper.model.yaml", "ball": f"model: {ball}, pose: [5, 0, 0]"}
    )


@pytest.mark.parametrize(
    ("x", "y", "noticed"),
    [
        (5.0, 0.0, set()),  # its bodies do not notice each other
        (-0.2, 0.0, {"/base", "/first"}),
        (0.3, 0.22, {"/area", "/arm"}),
        (0.6, 0.0, {"/arm"}),
    ],
)
def test_a_sensor_watches_one_body_only(files, x, y, noticed):
    """By default the first."""
    names = ("base", "area", "arm")
    plugins = [f"type: BoolSensor, name: {n}, topic: {n}, body: {n}" for n in names]
    world = gripper(files, *plugins, f"{SENSOR}, topic: first").run()

    move(world, x, y).run(0.1)

    assert {topic for topic in world.transport.topics if said(world, topic)} == noticed


def test_each_footprint_of_the_body_is_a_sensor(files):
    two = f"{AREA}, {{type: circle, center: [0, 1], radius: 0.2, density: 10, sensor: true}}"
    world = with_ball(files, footprint=two)

    assert said(move(world, 0.0, 1.0).run())
    assert said(move(world, 0.0, 0.0).run())
    assert not said(move(world, 0.0, 3.0).run())


# Duration


def test_a_touch_by_several_models_ends_with_the_last_one(files):
    ball = files.model("ball")
    others = {name: f"model: {ball}, pose: [{x}, 0, 0]" for name, x in (("a", -0.3), ("b", 0.3))}
    world = files.robot(SENSOR, footprint=AREA, others=others)

    assert said(world.run())
    assert said(move(world, 3.0, name="a").run())
    assert not said(move(world, 4.0, name="b").run())


@pytest.mark.parametrize("seconds", [0.01, 3.0])  # by then it is asleep
def test_a_deleted_model_touches_the_sensor_no_longer(files, seconds):
    world = move(with_ball(files), 0.1)
    assert said(world.run(seconds))

    world.world.delete_model("ball")

    assert not said(world.run())


def test_a_model_in_place_of_a_deleted_one_is_noticed(files):
    world = move(with_ball(files), 0.1).run(0.1)

    world.world.delete_model("ball")
    world.world.spawn_model(files.folder / "ball.model.yaml", "ball2", "", Pose(0.1, 0.0, 0.0))

    assert said(world.run())


@pytest.mark.parametrize("speed", [0.5, 2.0, 8.0])
def test_a_passing_body_is_reported_while_it_overlaps_the_sensor(files, speed):
    world = with_ball(files)

    world.model("ball").base.physics_body.velocity = (-speed, 0.0, 0.0)
    spoken = history(world, 1.6 / speed)

    # It comes in at 0.4 m, and leaves after 0.8 m.
    touched = sum(is_touched for _, is_touched in spoken) * STEP_NS * 1e-9
    assert touched == pytest.approx(0.8 / speed, abs=0.006)
    assert [spoken[0][1], spoken[-1][1]] == [False, False]


def test_without_subscribers_it_is_idle_yet_reads_the_same(files, no_subscribers, monkeypatch):
    calls = []
    step = BoolSensor.after_physics_step
    monkeypatch.setattr(
        BoolSensor, "after_physics_step", lambda self, time: (calls.append(time), step(self, time))
    )
    heard, unheard = (with_ball(files, transport=each) for each in (None, no_subscribers))
    sensor = unheard.world.plugins_of("robot")["sensor"]
    for world in (heard, unheard):
        world.model("ball").base.physics_body.velocity = (-100.0, 0.0, 0.0)  # 2 steps over the area

    measured = [unheard.run() and sensor.read(unheard.timekeeper) for _ in range(10)]

    assert measured == [said(heard.run()) for _ in range(10)]
    assert 0 < sum(measured) < 5
    assert len(calls) == 1 + 10  # the unheard one in its first step alone


# Latching


@pytest.mark.parametrize("begin", [0.02, 0.085, 0.09, 0.1, 0.105])  # it publishes at 0.105
@pytest.mark.parametrize("seconds", [0.005, 0.02, 0.095])
def test_a_touch_shorter_than_its_period_is_told_of_exactly_once(files, begin, seconds):
    world = with_ball(files, f"{SENSOR}, update_rate: 10")

    spoken = history(world, begin)
    spoken += history(move(world, 0.1), seconds)
    spoken += history(move(world, 1.0), 0.5)

    first_after = next(time for time, _ in spoken if time > begin * 1e9)
    assert [time for time, touched in spoken if touched] == [first_after]


def test_a_lasting_touch_is_published_until_it_ends(files):
    world = with_ball(files, f"{SENSOR}, update_rate: 10").run(0.02)

    lasting = history(move(world, 0.1), 0.5)
    after = history(move(world, 1.0), 0.5)

    assert [touched for _, touched in lasting] == [True] * 5
    assert [touched for _, touched in after] == [False] * 5


def test_a_touch_at_the_start_is_published_in_the_first_step(files):
    ball = files.model("ball")
    world = files.robot(SENSOR, footprint=AREA, others={"ball": f"model: {ball}"})

    assert history(world, 0.01) == [(STEP_NS, True), (2 * STEP_NS, True)]
