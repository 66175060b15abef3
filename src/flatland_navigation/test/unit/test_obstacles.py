"""Scans as points, and how far and how fast a robot may drive."""

import math

import numpy as np
import pytest

from flatland_navigation.obstacles import free_distance, safe_speed, scan_points, to_frame
from flatland_server import Pose


def test_points_of_a_scan():
    ranges = [1.0, math.inf, 2.0, math.nan, 31.0]
    quarter = math.pi / 2

    points = scan_points(ranges, -quarter, quarter, 30.0, Pose(1.0, 0.0, quarter))

    assert points == pytest.approx(np.array([[2.0, 0.0], [-1.0, 0.0]]))


def test_beams_of_a_laser_that_is_upside_down_turn_the_other_way():
    points = scan_points([1.0, 2.0], 0.0, math.pi / 2, 30.0, Pose(), handedness=-1.0)

    assert points == pytest.approx(np.array([[1.0, 0.0], [0.0, -2.0]]))


def test_points_in_the_robots_frame():
    pose = Pose(1.0, 2.0, 0.7)
    points = np.array([[0.3, -0.4], [2.0, 1.0]])

    outer = np.array([pose.apply(*point) for point in points])

    assert to_frame(outer, pose) == pytest.approx(points)


@pytest.mark.parametrize(
    ("point", "curvature", "expected"),
    [
        ((2.0, 0.0), 0.0, 1.8),  # ahead
        ((2.0, 0.19), 0.0, 2.0 - math.sqrt(0.2**2 - 0.19**2)),  # it grazes the side
        ((2.0, 0.21), 0.0, 5.0),  # beside
        ((-1.0, 0.0), 0.0, 5.0),  # behind
        ((0.1, 0.0), 0.0, 0.0),  # touched, ahead
        ((-0.1, 0.0), 0.0, 5.0),  # touched, behind
        ((1.0, 1.0), 1.0, math.pi / 2 - 2 * math.asin(0.1)),  # on a circle of 1 m radius
        ((1.0, -1.0), -1.0, math.pi / 2 - 2 * math.asin(0.1)),
        ((1.0, 1.0), -1.0, 5.0),
    ],
)
def test_distance_until_a_point_is_touched(point, curvature, expected):
    distance = free_distance(np.array([point, (4.0, 9.0)]), curvature, 0.2, 5.0)

    assert expected - 0.0201 <= distance <= expected


def test_without_points_all_is_free():
    assert free_distance(np.empty((0, 2)), 0.3, 0.2, 1.5) == 1.5


@pytest.mark.parametrize("delay", [0.0, 0.1, 1.0])
def test_a_robot_stops_within_the_distance(delay):
    speed = safe_speed(0.8, 0.5, delay)

    assert speed * delay + speed**2 / (2 * 0.5) == pytest.approx(0.8)
    assert safe_speed(0.0, 0.5, delay) == pytest.approx(0.0)
    assert safe_speed(-1.0, 0.5, delay) == pytest.approx(0.0)
