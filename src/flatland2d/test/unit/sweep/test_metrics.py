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


def result_of(settings, number=1):
    """The row of a scenario."""
    runner = ScenarioRunner(settings)
    try:
        return runner.run(scenarios_of(settings)[number - 1]).row
    finally:
        runner.close()


AHEAD = '[{name: ahead, call: "drivers.py:ahead"}]'


def test_a_straight_way_is_the_shortest_path(settings_of):
    row = result_of(settings_of(controllers=AHEAD, start="[-3, 0, 0]", goal="[-1, 0]"))

    assert row["success"]
    assert row["shortest_path"] == pytest.approx(1.7)  # to 0.3 m from the goal
    assert row["spl"] == pytest.approx(1.0, abs=0.01)
    assert row["barn_score"] is None


def test_the_shortest_path_leads_around_static_bodies(settings_of):
    keys = {"controllers": AHEAD, "start": "[0, 3, 0]", "goal": "[0, 1]", "time_limit": 0.1}

    row = result_of(settings_of(**keys))  # the box of 1 x 0.6 m is between the two

    assert 2.0 < row["shortest_path"] < 2.8
    assert row["spl"] == 0.0


def test_a_goal_that_cannot_be_reached_has_no_shortest_path(settings_of):
    row = result_of(settings_of(controllers=AHEAD, goal="[0, 9]", start=None, time_limit=0.1))

    assert row["shortest_path"] is None
    assert row["spl"] is None


def test_a_given_path_and_speed_give_the_score_of_barn(settings_of):
    keys = {"start": "[-3, 0, 0]", "goal": "[-1, 0]", "shortest_path": 1.0, "top_speed": 2.0}

    row = result_of(settings_of(controllers=AHEAD, **keys))  # 1.7 m at 0.5 m/s: 3.4 s

    assert row["shortest_path"] == 1.0
    assert row["barn_score"] == pytest.approx(0.5 / row["time"])


def test_a_collision_names_the_thing_that_was_hit(settings_of):
    row = result_of(settings_of(controllers=AHEAD, start="[2.5, 0, 0]", goal=None, time_limit=10))

    assert (row["collision"], row["collision_with"]) == (True, "walls")
    assert row["person_collision"] is None  # there are no people
    assert row["group_crossing_rate"] is None


def test_without_a_collision_nothing_was_hit(settings_of):
    row = result_of(settings_of(controllers=AHEAD, start="[0, 0, 0]", goal=None, time_limit=1))

    assert (row["collision"], row["collision_with"]) == (False, None)


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
def test_a_collision_is_attributed_to_robot_or_person(
    folder, settings_of, goal, speed, fault, speeds
):
    if goal:
        with (folder / "world.yaml").open("a") as world:
            world.write(MEETING.replace("GOAL", goal))
    controllers = f'[{{name: a, call: "drivers.py:ahead", arguments: {{speed: {speed}}}}}]'
    keys = {"start": "[-1.2, -2, 0]", "goal": "[3, 3]", "time_limit": 9.0}

    row = result_of(settings_of(controllers=controllers, **keys))

    assert row["person_collision"] == (None if goal is None else True)
    assert row["robot_at_fault"] == fault
    assert row["success_unless_hit"] == (None if fault is False else False)
    found = row["robot_speed_at_contact"], row["person_speed_at_contact"]
    assert found == tuple(each if each is None else pytest.approx(each, abs=0.2) for each in speeds)


def test_a_run_that_ends_before_its_goal_has_no_times_in_zones(folder, settings_of):
    with (folder / "world.yaml").open("a") as world:
        world.write(CROWD)
    keys = {"start": "[-3, 0, 0]", "time_limit": 8.0}

    arrived = result_of(settings_of(controllers=AHEAD, goal="[-1, 0]", **keys))
    passed = result_of(settings_of(controllers=AHEAD, goal="[2, 2]", **keys))

    assert arrived["personal_fraction"] + arrived["social_fraction"] == pytest.approx(1.0)
    assert passed["personal_fraction"] is passed["social_fraction"] is None
    assert passed["people_distance"] is not None


def test_distances_from_people_and_the_time_in_their_zones(folder, settings_of):
    with (folder / "world.yaml").open("a") as world:
        world.write(CROWD)
    keys = {"start": "[-3, 0, 0]", "goal": None, "time_limit": 8.0}

    row = result_of(settings_of(controllers=AHEAD, **keys))  # from x = -3 to 1 at 0.5 m/s

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


def test_the_time_in_the_hull_of_a_group(folder, settings_of):
    with (folder / "world.yaml").open("a") as world:
        world.write(GROUP)
    keys = {"start": "[-3, 0, 0]", "goal": None, "time_limit": 8.0}

    row = result_of(settings_of(controllers=AHEAD, **keys))  # from x = -3 to 1 at 0.5 m/s

    # Between the two of a group, 0.4 m of 4 m lead through the hull of their circles.
    assert row["group_crossing_rate"] == pytest.approx(0.1, abs=0.015)


@pytest.mark.parametrize(("y", "hit"), [(0.0, "people_0"), (2.0, "box")])
def test_person_collision_tells_whether_a_person_was_hit(folder, settings_of, y, hit):
    with (folder / "world.yaml").open("a") as world:
        world.write(CROWD.replace("-1, 0", "0, 0"))

    row = result_of(settings_of(controllers=AHEAD, start=f"[-2, {y}, 0]", goal=None, time_limit=20))

    assert row["collision_with"] == hit
    assert row["person_collision"] is (hit == "people_0")


def test_time_outs_and_paths_to_the_goal(settings_of):
    keys = {"controllers": AHEAD, "start": "[-3, 0, 0]", "goal": "[-1, 0]"}  # 1.7 m at 0.5 m/s

    late, arrived = (result_of(settings_of(**keys, time_limit=limit)) for limit in (2.0, 8.0))

    assert (late["timed_out"], late["path_to_goal"]) == (True, None)
    assert late["path_length"] == pytest.approx(1.0, abs=0.01)
    assert (arrived["timed_out"], arrived["path_to_goal"]) == (False, arrived["path_length"])


def test_without_people_there_are_no_distances_from_them(settings_of):
    row = result_of(settings_of(controllers=AHEAD, start="[0, 0, 0]", goal=None, time_limit=1))

    assert row["people_distance"] is None
    assert row["personal_fraction"] is None
