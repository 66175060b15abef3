"""The files of the documentation's tutorials run, and the robots in them drive."""

import logging
import math

import pytest

from flatland_server.plugins.plugin_loader import PluginLoader


def test_the_turtlebot_of_quick_start_drives(documented):
    simulation = documented.load("quick_start.world.yaml")
    world = simulation.world
    turtlebot = world.get_model("turtlebot")

    simulation.drive(0.5, 0.2).run(1.0)

    assert world.layers[0].name == "map"
    assert world.layers[0].config.color == (0.4, 0.4, 0.4, 1.0)
    assert world.layers[0].segments.min(axis=0)[:2] == pytest.approx((-16.6, -6.65))
    assert len(turtlebot.base.config.footprints) == 4
    arc = (2.5 * math.sin(0.2), 2.5 * (1 - math.cos(0.2)), 0.2)
    assert turtlebot.pose == pytest.approx(arc, abs=1e-3)


def test_the_cleaner_of_create_model_is_complete(documented):
    cleaner = documented.model("cleaner.model.yaml")

    names = ["base", "front_wheel", "rear_left_wheel", "rear_right_wheel"]
    assert [body.name for body in cleaner.bodies] == names
    assert len(cleaner.bodies[0].footprints[0].shape.vertices) == 6
    assert len(cleaner.joints) == 3
    kinds = ["ModelTfPublisher", "TricycleDrive", "Laser"]
    assert [plugin.type for plugin in cleaner.plugins] == kinds


@pytest.mark.parametrize("steering", [0.0, 0.4, -1.2])
def test_the_cleaner_of_create_model_drives(documented, steering):
    cleaner = documented.spawn("cleaner.model.yaml")
    speed, seconds, wheelbase = 0.5, 2.0, 0.83

    scans = cleaner.drive(speed, steering).record("/scan", seconds)

    # The front wheel, at the base's origin, moves in its heading; the base turns about the
    # intersection of the axles.
    turn_rate = speed * math.sin(steering) / wheelbase
    yaw = turn_rate * seconds
    x, y = speed * seconds, 0.0
    if steering:
        radius = speed / turn_rate
        x = radius * (math.sin(yaw + steering) - math.sin(steering))
        y = -radius * (math.cos(yaw + steering) - math.cos(steering))
    assert cleaner.pose("base") == pytest.approx((x, y, yaw), abs=1e-3)
    assert cleaner.pose("front_wheel") == pytest.approx((x, y, yaw + steering), abs=1e-2)
    assert len(scans) == 2.0 * 40
    odometry = cleaner.transport.last("/odometry/filtered")
    assert (odometry.header.frame_id, odometry.child_frame_id) == ("map", "base")
    on_base = ("front_wheel", "rear_left_wheel", "rear_right_wheel", "laser_front")
    assert cleaner.frames == {("map", "base"), *(("base", name) for name in on_base)}


def test_the_plugin_of_create_plugin_says_hello_from_the_cleaner(documented, caplog):
    caplog.set_level(logging.INFO)
    documented.files.loader = PluginLoader()  # of all packages
    documented.files.edit(
        "cleaner.model.yaml", "plugins:\n", "plugins:\n- type: Simple\n  name: simple\n\n"
    )

    documented.spawn("cleaner.model.yaml")

    assert [record.getMessage() for record in caplog.records].count("Hello world") == 1


def test_the_model_of_create_custom_robot_is_at_its_pose(documented):
    simulation = documented.load("your_custom_world.yaml").run(0.1)

    robot = simulation.world.get_model("your_custom_model")
    assert robot.base.config.color == (1.0, 1.0, 1.0, 1.0)
    assert robot.base.config.footprints[0].density == 100.0
    assert robot.pose == (0.0, 0.0, 0.0)


def test_the_plugin_of_writing_model_plugins_moves_its_model(documented):
    documented.files.loader = PluginLoader()  # of all packages
    robot = documented.spawn("const_velocity.model.yaml")

    robot.run(1.0)

    assert robot.pose() == pytest.approx((1.0, 0.2, -0.5), abs=1e-5)
