"""The score of a way to a goal."""

import math

import pytest

from flatland_navigation.score import GoalScore, table
from flatland_server import Pose


def drive(score: GoalScore, *points, clearance=1.0) -> GoalScore:
    for i, (x, y) in enumerate(points):
        score.add_pose(10.0 + 0.5 * i, Pose(x, y, 0.0), clearance)
    return score


def test_a_detour_lowers_spl_by_its_length():
    score = drive(GoalScore(1, 2.0), (0, 0), (0, 1), (2, 1), (2, 0))

    row = score.row("goal")

    assert (row["success"], row["time"], row["path_length"]) == (True, 1.5, 4.0)
    assert row["spl"] == 0.5
    assert score.row("aborted")["spl"] == 0.0


def test_a_contact_is_counted_when_it_begins_and_is_no_success():
    score = drive(GoalScore(1, 1.0), (0, 0), (1, 0))
    wall, box = ("map", "map"), ("box_1", "base")

    for touched in (set(), {wall}, {wall}, {wall, box}, set(), {wall}):
        score.add_contacts(touched)

    row = score.row("goal")
    assert (row["contacts"], row["success"], row["outcome"], row["spl"]) == (3, False, "goal", 0.0)


def test_clearance_errors_and_changes_of_the_command():
    score = drive(GoalScore(3, None), (0, 0), (1, 0), clearance=0.5)
    score.add_pose(11.0, Pose(2.0, 0.0, 0.3), 0.2)
    for error in (0.1, 0.3):
        score.add_error(error)
    for command in ((0.0, 0.0, 0.0), (0.3, 0.4, 0.0), (0.3, 0.4, 0.3), (0.3, 0.1, -0.3)):
        score.add_command(*command)

    row = score.row("goal")

    assert row["min_clearance"] == 0.2
    assert row["localization_error"] == pytest.approx(0.2)
    assert row["max_localization_error"] == 0.3
    assert (row["speed_change"], row["turn_change"]) == (pytest.approx(0.8), pytest.approx(0.9))
    assert row["heading_change"] == pytest.approx(0.3)
    assert (row["shortest_path"], row["spl"]) == (None, None)


def test_a_rejected_goal_has_no_figures_in_the_table():
    rows = [GoalScore(1, 1.0).row("rejected"), drive(GoalScore(2, 1.0), (0, 0), (1, 0)).row("goal")]

    assert rows[0]["min_clearance"] is None
    assert not any(isinstance(value, float) and math.isnan(value) for value in rows[0].values())
    names, first, second = table(rows).splitlines()
    assert names.split()[:3] == ["goal", "outcome", "success"]
    assert first.split()[:4] == ["1", "rejected", "False", "0.00"]
    assert "1.00" in second
