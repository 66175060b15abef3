"""Pure pursuit: its curvature, and how exactly a path is followed."""

import math

import numpy as np
import pytest

from flatland_navigation.follower import FollowerConfig, PathFollower, pursuit_curvature, sample
from flatland_server import Pose, wrap_angle

PERIOD = 0.05  # s


def moved(pose, command):
    """A robot's pose one period later, on the arc of a command."""
    turn = command.turn * PERIOD
    length = command.forwards * PERIOD
    chord = length * (math.sin(turn / 2) / (turn / 2) if turn else 1.0)
    x, y = pose.apply(chord * math.cos(turn / 2), chord * math.sin(turn / 2))
    return Pose(x, y, pose.yaw + turn)


def follow(follower, pose, seconds):
    """The robot's poses."""
    poses = [pose]
    for _ in range(round(seconds / PERIOD)):
        command = follower.command(poses[-1], PERIOD)
        if follower.is_done(poses[-1]):
            break
        poses.append(moved(poses[-1], command))
    return poses


@pytest.mark.parametrize("turn", [-2.5, -1.0, 0.3, 1.5])
def test_the_arc_leads_to_the_point(turn):
    """A point on an arc of radius 2 m that begins in the robot's direction."""
    x, y = 2.0 * math.sin(abs(turn)), math.copysign(2.0 * (1.0 - math.cos(turn)), turn)

    assert pursuit_curvature(x, y) == pytest.approx(math.copysign(0.5, turn))


def test_the_curvature_towards_a_point_ahead_or_here_is_zero():
    assert pursuit_curvature(1.0, 0.0) == 0.0
    assert pursuit_curvature(0.0, 0.0) == 0.0


def test_a_circle_is_tracked_within_a_centimetre():
    angles = np.linspace(0.0, 1.5 * math.pi, 400)
    circle = 2.0 * np.column_stack([np.cos(angles), np.sin(angles)])
    config = FollowerConfig(max_speed=0.5, lookahead=0.4)

    poses = follow(PathFollower(circle, math.pi, config), Pose(2.0, 0.0, math.pi / 2), 60.0)

    errors = [abs(math.hypot(pose.x, pose.y) - 2.0) for pose in poses]
    assert max(errors) < 0.01
    assert math.dist(poses[-1][:2], circle[-1]) <= config.xy_goal_tolerance


def test_a_robot_beside_a_line_comes_back_to_it():
    line = np.array([[0.0, 0.0], [5.0, 0.0]])

    poses = follow(PathFollower(line, 0.0, FollowerConfig()), Pose(0.0, 0.25, 0.0), 60.0)

    assert max(abs(pose.y) for pose in poses if pose.x > 2.0) < 0.01


def test_it_turns_first_when_the_path_leads_elsewhere():
    path = np.array([[0.0, 0.0], [-3.0, 0.0]])
    follower = PathFollower(path, math.pi, FollowerConfig(max_turn_rate=1.0))

    command = follower.command(Pose(), PERIOD)
    poses = follow(follower, Pose(), 60.0)

    assert command.forwards == 0.0
    assert abs(command.turn) == 1.0
    assert max(abs(pose.y) for pose in poses) < 0.05
    assert poses[-1].x == pytest.approx(-3.0, abs=0.1)


def test_the_goal_is_a_place_and_a_heading():
    config = FollowerConfig(xy_goal_tolerance=0.1, yaw_goal_tolerance=0.05)
    follower = PathFollower(np.array([[0.0, 0.0], [2.0, 1.0]]), -2.0, config)

    poses = follow(follower, Pose(), 60.0)

    assert math.dist(poses[-1][:2], (2.0, 1.0)) <= 0.1
    assert abs(wrap_angle(poses[-1].yaw + 2.0)) <= 0.05
    assert follower.is_done(poses[-1])


def test_speeds_stay_within_limits():
    config = FollowerConfig(max_speed=0.4, max_turn_rate=0.6, deceleration=0.5)
    corners = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])
    follower = PathFollower(corners, 0.0, config)
    pose = Pose()
    for _ in range(800):
        command = follower.command(pose, PERIOD)
        assert 0.0 <= command.forwards <= 0.4
        assert abs(command.turn) <= 0.6 + 1e-9
        distance = max(follower.remaining, math.hypot(pose.x, pose.y - 2.0))
        assert command.forwards**2 <= 2 * 0.5 * distance + 1e-9
        pose = moved(pose, command)
    assert follower.is_done(pose)


def test_corners_are_not_cut_where_there_is_a_wall():
    """The lookahead shrinks while the line to the point ahead is not free."""
    corners = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0]])

    def is_free(start, end):
        middle = (start[0] + end[0]) / 2, (start[1] + end[1]) / 2
        return not (middle[0] < 1.95 and middle[1] > 0.05)

    def least_distance(follower):
        poses = follow(follower, Pose(), 60.0)
        return min(math.dist(pose[:2], (2.0, 0.0)) for pose in poses)

    config = FollowerConfig(lookahead=0.6, turn_in_place_angle=2.0)
    cut = least_distance(PathFollower(corners, 0.0, config))
    kept = least_distance(PathFollower(corners, 0.0, config, is_free))
    assert kept < 0.07 < cut


def test_long_periods_make_it_slow():
    line = np.array([[0.0, 0.0], [50.0, 0.0]])

    command = PathFollower(line, 0.0, FollowerConfig()).command(Pose(), 1.0)

    assert command.forwards == pytest.approx(0.4 / 4.0)


def test_samples_have_both_ends_and_the_spacing():
    points, lengths = sample(np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 0.52]]), 0.05)

    assert points[0].tolist() == [0.0, 0.0]
    assert points[-1].tolist() == [1.0, 0.52]
    assert lengths[-1] == pytest.approx(1.52)
    assert np.diff(lengths).max() <= 0.05
