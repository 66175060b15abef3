"""Bumper: the begin, the rest and the end of collisions, for every cause of an end."""

import pytest
from bumping import BOX, BUMPER, MASS, impulse, names, now, press, record, throw, vectors, wall

from flatland_server.geometry import Pose
from flatland_server.plugins.model_plugin import ModelPlugin
from flatland_server.plugins.plugin_loader import PluginDeclaration, PluginLoader, discover


class Ghost(ModelPlugin):
    """Lets its model pass through everything from a time on."""

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
    return PluginLoader([*discover(), PluginDeclaration.of(Ghost)])


def test_a_contact_disabled_by_another_plugin_is_not_reported(files):
    ghost = "type: Ghost, name: ghost"
    robot = throw(files.robot(BUMPER, ghost, layers=wall(files)), 1.0)

    assert record(robot, 2.0) == []
    assert robot.model().pose.x == pytest.approx(2.0, abs=1e-3)


def test_a_contact_that_is_disabled_later_ends_the_collision(files):
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


def test_a_resting_contact_is_reported_without_force(files):
    robot = throw(files.robot(BUMPER, layers=wall(files)), 1.0).run(1.0)
    [touch] = now(robot)

    reported = robot.record("/collisions", 2.0)

    assert not robot.model().base.physics_body.awake
    assert len(reported) == 400
    for message in reported:
        [collision] = message.collisions
        assert collision.magnitude_forces == [pytest.approx(0.0, abs=1e-3)]
        assert names(collision) == names(touch)
        assert collision.contact_positions == touch.contact_positions
        assert collision.contact_normals == touch.contact_normals
    assert reported[-1].collisions[0].magnitude_forces == [0.0]


def test_a_resting_body_reports_the_force_of_the_next_push(files):
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

    reported = {vectors(each.contact_normals)[0][0]: each for each in now(robot)}
    assert set(reported) == {-1.0, 1.0}
    assert reported[-1.0].magnitude_forces == [0.0]
    assert impulse([reported[1.0]]) == pytest.approx(MASS * 60.0, rel=1e-4)
    robot.run()
    assert [vectors(each.contact_normals)[0][0] for each in now(robot)] == [1.0]


def test_a_robot_that_is_moved_away_leaves_its_collisions_behind(files):
    robot = throw(files.robot(BUMPER, layers=wall(files)), 1.0).run(3.0)

    robot.world.move_model("robot", Pose(-2.0, 0.0, 0.0))
    robot.run()

    assert now(robot) == []


@pytest.mark.parametrize("seconds", [1.0, 4.0])  # by then all is at rest, and asleep
def test_a_deleted_model_collides_no_longer_and_one_in_its_place_does(files, seconds):
    post = files.model("post", footprint=BOX, body="type: static,")
    robot = files.robot(BUMPER, others={"post": f"model: {post}, pose: [1, 0, 0]"})
    throw(robot, 1.0).run(seconds)
    assert [names(each)[2] for each in now(robot)] == ["post"]

    robot.world.delete_model("post")
    robot.run()
    assert now(robot) == []
    robot.world.spawn_model(files.folder / post, "pillar", "", Pose(1.0, 0.0, 0.0))
    press(robot, (1.0, 0.0), 0.5)

    assert [names(each)[2] for each in now(robot)] == ["pillar"]
