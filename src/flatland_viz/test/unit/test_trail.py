"""The ways of robots, and what their odometry believes."""

import math
from types import SimpleNamespace

import pytest
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Float64

from flatland_viz.model_list import Topic
from flatland_viz.plotted_values import paths_of, split, value_of
from flatland_viz.trail import Line, Trail
from flatland_viz.trail_display import odometry_topic


def test_a_trail_is_sampled_and_is_cut_when_time_goes_back():
    line = Line()
    for step in range(101):
        line.add(step / 100, step / 100, 0.0)

    assert 17 <= len(line.points) <= 21
    line.has_changed = False
    line.add(1.01, 1.0, 0.0)
    assert not line.has_changed
    line.add(0.5, 0.5, 0.0)
    assert line.points[-1][0] == pytest.approx(0.5, abs=0.06)
    assert line.has_changed


def test_a_robot_that_was_put_elsewhere_begins_anew():
    line = Line()
    for time, x in ((0.0, 0.0), (0.1, 0.1), (0.2, 3.0), (0.3, 3.1)):
        line.add(time, x, 0.0)

    assert line.points == [(3.0, 0.0), (3.1, 0.0)]


def test_the_odometry_trail_begins_at_the_robot():
    trail = Trail()
    trail.believe(0.0, (5.0, 0.0, 0.0))  # the robot is not seen yet
    trail.see(0.0, (2.0, 3.0, math.pi / 2))
    trail.believe(0.0, (10.0, 0.0, 0.0))
    trail.believe(1.0, (11.0, 0.0, 0.0))

    assert trail.truth.points == [(2.0, 3.0)]
    assert trail.belief.points == [pytest.approx((2.0, 3.0)), pytest.approx((2.0, 4.0))]


def test_the_odometry_of_a_robot_is_not_its_ground_truth():
    def topic(name, is_published=True):
        return Topic(name, "nav_msgs/Odometry", is_published, "drive")

    names = ("/r1/odometry/ground_truth", "/r1/odometry/filtered")
    robot = SimpleNamespace(topics=[topic("/in", False), *map(topic, names)])

    assert odometry_topic(robot) == "/r1/odometry/filtered"
    assert odometry_topic(SimpleNamespace(topics=[])) == odometry_topic(None) == ""


def test_the_name_of_a_plot_is_a_topic_with_or_without_a_field():
    topics = {"/r1/odom": "nav_msgs/Odometry", "/r1/odom/raw": "nav_msgs/Odometry"}

    assert split("/r1/odom", topics) == ("/r1/odom", "")
    assert split("/r1/odom/twist/twist/linear/x", topics) == ("/r1/odom", "twist.twist.linear.x")
    assert split("/r1/odom/raw.pose", topics) == ("/r1/odom/raw", "pose")
    assert split("/r1/odometry", topics) == ("", "")


@pytest.mark.parametrize(
    ("message", "path", "expected"),
    [
        (Float64(2.0), "", {"data": 2.0}),
        (Odometry(), "", {"twist.twist.linear.x": 0.0, "twist.twist.angular.z": 0.0}),
        (Odometry(), "pose.pose.position.y", {"pose.pose.position.y": 0.0}),
        (Twist(), "linear", {"linear.x": 0.0, "linear.y": 0.0, "linear.z": 0.0}),
        (LaserScan(range_max=9.0, ranges=[math.inf, 3.0, 2.0]), "", {"nearest": 2.0}),
        (LaserScan(ranges=[5.0]), "ranges[0]", {"ranges[0]": 5.0}),
        (LaserScan(), "ranges[0]", {}),
        (Float64(), "nothing", {}),
    ],
)
def test_numbers_of_messages_are_found_by_their_path(message, path, expected):
    paths = paths_of(message._type, message, path)

    assert {each: value_of(message, each) for each in paths} == expected
