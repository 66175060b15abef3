"""Metrics of runs against cases that were computed by hand."""

import math

import numpy as np
import pytest

from flatland2d.sweep.metrics import barn_score, motion_metrics
from flatland2d.sweep.runner import ScenarioRunner
from flatland2d.sweep.settings import scenarios_of
from flatland_navigation.score import spl
from flatland_server.geometry import Pose


def test_success_weighted_by_path_length():
    assert spl(True, 4.0, 5.0) == pytest.approx(0.8)
    assert spl(True, 4.0, 3.9) == 1.0  # shorter than the planner's path
    assert spl(False, 4.0, 5.0) == 0.0
    assert spl(True, 0.0, 0.0) == 1.0


@pytest.mark.parametrize(
    ("time", "score"),  # 10 m at 2 m/s: 5 s
    [(5.0, 0.5), (10.0, 0.5), (20.0, 0.25), (40.0, 0.125), (99.0, 0.125)],
)
def test_the_score_of_barn(time, score):
    assert barn_score(True, 10.0, time, 2.0) == pytest.approx(score)
    assert barn_score(False, 10.0, time, 2.0) == 0.0


def test_standing_turning_and_driving():
    times = [0.0, 0.5, 1.0, 1.5, 2.0]
    poses = [
        Pose(0.0, 0.0, 3.0),
        Pose(0.0, 0.0, 3.0),  # stands
        Pose(0.0, 0.0, -3.0),  # turns by 6.283 - 6
        Pose(0.1, 0.0, -3.0),
        Pose(0.1, 0.004, -3.004),  # slower than 0.01 m/s and 0.01 rad/s
    ]

    found = motion_metrics(times, poses)

    assert found["stalled_time"] == pytest.approx(1.0)
    assert found["heading_change"] == pytest.approx(math.tau - 6.0 + 0.004)


def test_jerk_of_a_cubic_is_its_third_derivative():
    times = [0.1 * k for k in range(8)]
    poses = [Pose(2.0 * t**3, -1.5 * t**3, 0.0) for t in times]  # 12 and -9 m/s^3

    assert motion_metrics(times, poses)["mean_jerk"] == pytest.approx(15.0)


def test_jerk_needs_four_poses_at_equal_intervals():
    poses = [Pose(float(k * k), 0.0, 0.0) for k in range(5)]

    assert motion_metrics([0.0, 1.0, 2.0], poses[:3])["mean_jerk"] is None
    assert motion_metrics([0.0, 1.0, 3.0, 4.0, 6.0], poses)["mean_jerk"] is None
    assert motion_metrics([0.0, 1.0, 2.0, 3.0, 5.0], poses)["mean_jerk"] == pytest.approx(0.0)


def test_a_run_without_control_steps_has_no_motion():
    found = motion_metrics([0.0], [Pose()])

    assert found == {"stalled_time": 0.0, "heading_change": 0.0, "mean_jerk": None}


@pytest.fixture
def ahead(folder, settings_of):
    """The row of a robot that drives ahead, from x = -3 by default, in a world with more."""

    def run(more="", *, speed=0.5, start="[-3, 0, 0]", **keys):
        with (folder / "world.yaml").open("a") as world:
            world.write(more)
        call = f'[{{name: a, call: "drivers.py:ahead", arguments: {{speed: {speed}}}}}]'
        settings = settings_of(controllers=call, start=start, **keys)
        runner = ScenarioRunner(settings)
        return runner.run(scenarios_of(settings)[0]).row

    return run


def test_a_straight_way_is_the_shortest_path(ahead):
    row = ahead(goal="[-1, 0]")

    assert row["success"]
    assert row["shortest_path"] == pytest.approx(1.7)  # to 0.3 m from the goal
    assert row["spl"] == pytest.approx(1.0, abs=0.01)
    assert row["barn_score"] is None
    assert row["people_distance"] is row["personal_fraction"] is None  # there are none


def test_the_shortest_path_leads_around_static_bodies(ahead):
    row = ahead(start="[0, 3, 0]", goal="[0, 1]", time_limit=0.1)  # a box of 1 x 0.6 m between

    assert 2.0 < row["shortest_path"] < 2.8
    assert row["spl"] == 0.0
    row = ahead(start=None, goal="[0, 9]", time_limit=0.1)  # behind a wall
    assert row["shortest_path"] is row["spl"] is None


def test_a_given_path_and_speed_give_the_score_of_barn(ahead):
    row = ahead(goal="[-1, 0]", shortest_path=1.0, top_speed=2.0)  # 1.7 m at 0.5 m/s: 3.4 s

    assert row["shortest_path"] == 1.0
    assert row["barn_score"] == pytest.approx(0.5 / row["time"])


@pytest.mark.parametrize(
    ("start", "people", "hit", "is_person"),
    [
        ("[2.5, 0, 0]", False, "walls", None),
        ("[0, 0, 0]", False, None, None),  # within the time limit
        ("[-2, 0, 0]", True, "people_0", True),
        ("[-2, 2, 0]", True, "box", False),
    ],
)
def test_a_collision_names_the_thing_that_was_hit(ahead, start, people, hit, is_person):
    more = CROWD.replace("-1, 0", "0, 0") if people else ""

    row = ahead(more, start=start, goal=None, time_limit=10 if hit else 1)

    assert (row["collision"], row["collision_with"]) == (hit is not None, hit)
    assert row["person_collision"] is is_person
    assert row["group_crossing_rate"] is None


CROWD = """
plugins:
  - type: Crowd
    name: people
    sees_robots: false
    pedestrians: [{pose: [0, -1, 0], radius: 0.25}]
"""


MEETING = """
plugins:
  - type: Crowd
    name: people
    sees_robots: false
    force: {noise: 0}
    pedestrians: [{pose: [0, -2, 3.14], goals: [GOAL], radius: 0.25, speed: 1}]
"""


@pytest.mark.parametrize(
    ("goal", "speed", "fault", "speeds"),
    [
        ("[-4, -2]", 0.0, False, (0.0, 1.0)),  # the robot stands
        ("[-4, -2]", 0.5, True, (0.5, 0.8)),  # towards each other
        ("[0, -2]", 0.5, True, (0.5, 0.0)),  # the person stands
        ("[-4, -2]", -0.5, False, (0.5, 1.0)),  # the robot drives away, too slowly
        (None, 0.0, None, (None, None)),
    ],
)
def test_a_collision_is_attributed_to_robot_or_person(ahead, goal, speed, fault, speeds):
    more = MEETING.replace("GOAL", goal) if goal else ""

    row = ahead(more, speed=speed, start="[-1.2, -2, 0]", goal="[3, 3]", time_limit=9.0)

    assert row["person_collision"] == (None if goal is None else True)
    assert row["robot_at_fault"] == fault
    assert row["success_unless_hit"] == (None if fault is False else False)
    found = row["robot_speed_at_contact"], row["person_speed_at_contact"]
    assert found == tuple(each if each is None else pytest.approx(each, abs=0.2) for each in speeds)


def test_a_run_that_ends_before_its_goal_has_no_times_in_zones(ahead):
    arrived = ahead(CROWD, goal="[-1, 0]", time_limit=8.0)
    passed = ahead(goal="[2, 2]", time_limit=8.0)

    assert arrived["personal_fraction"] + arrived["social_fraction"] == pytest.approx(1.0)
    assert passed["personal_fraction"] is passed["social_fraction"] is None
    assert passed["people_distance"] is not None


def test_distances_from_people_and_the_time_in_their_zones(ahead):
    row = ahead(CROWD, goal=None, time_limit=8.0)  # from x = -3 to 1 at 0.5 m/s

    ahead = -3.0 + 0.5 * 0.05 * np.arange(1, 161)  # at control steps of 0.05 s
    distances = np.hypot(ahead, 1.0) - 0.2 - 0.25  # less the radii of the robot and the person
    assert row["people_distance"] == pytest.approx(0.55, abs=0.005)
    assert row["mean_people_distance"] == pytest.approx(distances.mean(), abs=0.01)
    assert row["intimate_fraction"] == 0.0
    assert row["personal_fraction"] == pytest.approx((distances < 1.2).mean(), abs=0.02)
    assert row["social_fraction"] == pytest.approx((distances >= 1.2).mean(), abs=0.02)


GROUP = """
plugins:
  - type: Crowd
    name: people
    sees_robots: false
    pedestrians:
      - {pose: [-2, 1, 0], radius: 0.2, group: a}
      - {pose: [-2, -1, 0], radius: 0.2, group: a}
      - {pose: [3, 2, 0], radius: 0.2, group: b}
      - {pose: [0, -3, 0], radius: 0.2}
"""


def test_the_time_in_the_hull_of_a_group(ahead):
    row = ahead(GROUP, goal=None, time_limit=8.0)  # from x = -3 to 1 at 0.5 m/s

    # Between the two of a group, 0.4 m of 4 m lead through the hull of their circles.
    assert row["group_crossing_rate"] == pytest.approx(0.1, abs=0.015)


def test_time_outs_and_paths_to_the_goal(ahead):
    late, arrived = (ahead(goal="[-1, 0]", time_limit=limit) for limit in (2.0, 8.0))

    assert (late["timed_out"], late["path_to_goal"]) == (True, None)
    assert late["path_length"] == pytest.approx(1.0, abs=0.01)  # at 0.5 m/s
    assert (arrived["timed_out"], arrived["path_to_goal"]) == (False, arrived["path_length"])
