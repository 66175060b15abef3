"""Collection of problems by the window."""

from flatland_viz.model_list import Model, Topic
from flatland_viz.problems import (
    Problem,
    Problems,
    frames_published_twice,
    shared_commands,
    summary,
)

FAILED = Problem("server: plugin a/b", "switched off", True, 1, 1.0)


def test_the_latest_problem_of_all_groups_comes_first():
    warning = Problem("transforms", "old", False, 1, 1.0)
    problems = Problems()
    problems.report("w", [warning])
    problems.report("d", [FAILED])
    assert problems.latest_first == [FAILED, warning]
    assert problems.has_errors

    problems.report("w", [warning._replace(times=2)])
    assert problems.latest_first == [warning._replace(times=2), FAILED]


def test_states_last_until_they_are_reported_no_more():
    problems = Problems()
    problems.report("d", [FAILED])
    problems.report("d", [FAILED._replace(time=2.0)])
    problems.report("other", [])
    assert problems.latest_first == [FAILED]

    problems.report("d", [])
    assert problems.latest_first == []


def test_a_cleared_problem_returns_when_it_begins_again():
    problems = Problems()
    problems.report("d", [FAILED])
    problems.clear()
    problems.report("d", [FAILED])
    assert not problems.latest_first

    problems.report("d", [])
    problems.report("d", [FAILED._replace(time=4.0)])
    assert [problem.time for problem in problems.latest_first] == [4.0]


def test_a_repeated_log_entry_comes_back_with_its_number():
    log = [Problem("/server", text, False, times, 1.0) for text, times in (("a", 3), ("b", 1))]
    problems = Problems()
    problems.report("log", log)
    assert problems.latest_first == log[::-1]

    problems.clear()
    repeated = log[0]._replace(times=4, time=2.0)
    problems.report("log", [log[1], repeated])
    assert problems.latest_first == [repeated]


def test_frames_of_two_nodes_are_named():
    seen = [("map", "odom", "/server"), ("world", "odom", "/amcl"), ("odom", "base", "/server")]
    assert frames_published_twice(seen[::2]) == []

    assert frames_published_twice(seen) == [
        '/amcl and /server publish the frame "odom" from "map" and "world"; switch one off'
    ]


def test_robots_with_the_same_commands_are_named():
    def model(name, *commands):
        topics = tuple(Topic(each, "geometry_msgs/Twist", False, "drive") for each in commands)
        return Model(name, "", "", (), (), topics, 0.4, False)

    others = {"r3": ["/r3/cmd_vel"], "a": [], "b": []}
    for count, listed in ((2, "r1 and r2"), (5, "r3, r1, r2 and 2 others")):
        names = {**others, **{f"r{number + 1}": ["/cmd_vel"] for number in range(count)}}
        [text] = shared_commands(model(name, *commands) for name, commands in names.items())
        assert text.startswith(f"{listed} subscribe to /cmd_vel:")


def test_a_traceback_is_shown_by_its_exception():
    text = "the plugin failed\nTraceback (most recent call last):\n  File x\nValueError: no"

    assert summary(text) == "the plugin failed: ValueError: no"
    assert summary("two\n lines") == "two lines"
