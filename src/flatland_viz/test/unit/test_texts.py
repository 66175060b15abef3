"""Texts of the window: messages in a few words, errors, and the page with its keys."""

import math

import pytest
from flatland_msgs.msg import Collision, Collisions
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan, NavSatFix
from std_msgs.msg import Bool, String

from flatland_viz.error_text import error_text
from flatland_viz.keys_dialog import page
from flatland_viz.topic_values import describe, velocity


def odometry(x, y, yaw):
    message = Odometry()
    pose = message.pose.pose
    pose.position.x, pose.position.y = x, y
    pose.orientation.z, pose.orientation.w = math.sin(yaw / 2), math.cos(yaw / 2)
    return message


@pytest.mark.parametrize(
    ("message", "text"),
    [
        (odometry(1.0, -0.001, math.pi / 2), "1.00, 0.00 m, 90°"),
        (LaserScan(ranges=[math.inf, 2.5, 1.25, math.nan], range_max=10.0), "nearest 1.25 m"),
        (LaserScan(ranges=[math.inf], range_max=10.0), "hits nothing"),
        (Collisions(collisions=[Collision(entity_B=b) for b in "aba"]), "touches a, b"),
        (Collisions(), "touches nothing"),
        (Bool(True), "yes"),
        (NavSatFix(latitude=48.1371, longitude=11.5754), "48.137100°, 11.575400°"),
        (Twist(), "0.00 m/s, 0.00 rad/s"),
        (String(), ""),
    ],
)
def test_messages_are_described(message, text):
    assert describe(message._type, message) == text


def test_a_sideways_velocity_is_named_only_if_there_is_one():
    assert velocity(0.5, 0.0, -0.2) == "0.50 m/s, -0.20 rad/s"
    assert velocity(0.5, -0.25, 0.0) == "0.50 m/s, 0.25 m/s to the right, 0.00 rad/s"
    assert velocity(-0.001, 0.01, -0.001) == "0.00 m/s, 0.01 m/s to the left, 0.00 rad/s"


@pytest.mark.parametrize(
    ("message", "text"),
    [
        ('ModelError: a model named "a" is already there', 'a model named "a" is already there'),
        ("YamlError: a.yaml:3: no key\na.yaml:5: none", "a.yaml:3: no key\na.yaml:5: none"),
        ("ValueError: YamlError: twice", "YamlError: twice"),
        ("robot.yaml:4: not YAML", "robot.yaml:4: not YAML"),
        ("of an older server: ModelError: x", "of an older server: ModelError: x"),
        ("", ""),
    ],
)
def test_the_exception_class_is_left_out(message, text):
    assert error_text(message) == text


def test_tables_without_rows_are_left_out():
    text = page([[("World", [("F5", "Reload <files>")]), ("Help", [])]])

    assert "World" in text
    assert "F5" in text
    assert "Reload &lt;files&gt;" in text
    assert "Help" not in text
