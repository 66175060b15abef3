"""The commands of keys and of the pad, and the robots that can be driven."""

from types import SimpleNamespace

from python_qt_binding.QtCore import Qt

from flatland_viz.drive_command import STOP, Command, Speeds, of_keys, of_pad, velocity
from flatland_viz.drive_pad import part_of
from flatland_viz.drive_robots import Robot, robots_of
from flatland_viz.model_list import models_of


def test_qts_keys_drive():
    assert of_keys(set()) == STOP
    assert of_keys({Qt.Key_Up, Qt.Key_Left}) == Command(forwards=1.0, turn=1.0)
    assert of_keys({Qt.Key_W, Qt.Key_S, Qt.Key_E}) == Command(left=-1.0)


def test_the_right_of_the_pad_is_clockwise():
    assert of_pad(right=0.5, up=1.0) == Command(forwards=1.0, turn=-0.5)


def test_a_knob_near_an_axis_is_on_it():
    assert part_of(2.0, 60.0) == 0.0
    assert part_of(-30.0, 60.0) == -0.5
    assert part_of(500.0, 60.0) == 1.0


def test_velocities_are_parts_of_the_greatest_speeds():
    command = Command(forwards=0.5, left=-1.0, turn=1.0)

    assert velocity(command, Speeds(2.0, 3.0)) == (1.0, -2.0, 3.0)
    assert velocity(command, Speeds(2.0, 3.0), factor=0.5) == (0.5, -1.0, 1.5)


def plugin(kind, topic, is_published=False):
    topics = [SimpleNamespace(name=topic, type="geometry_msgs/Twist", is_published=is_published)]
    return SimpleNamespace(name="p", type=kind, has_failed=False, topics=topics)


def test_robots_are_models_that_subscribe_to_commands():
    plugins = {
        "r10": plugin("DiffDrive", "/r10/cmd_vel"),
        "r2": plugin("TricycleDrive", "/r2/go"),
        "box": plugin("Echo", "/echo", is_published=True),
    }
    models = [
        SimpleNamespace(name=name, ns="", yaml_path="", bodies=[], plugins=[each])
        for name, each in plugins.items()
    ]

    robots = robots_of(models_of(SimpleNamespace(models=models)).values())

    assert robots == [Robot("r2", "/r2/go", True), Robot("r10", "/r10/cmd_vel", False)]
