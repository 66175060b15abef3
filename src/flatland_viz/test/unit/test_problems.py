"""Collection of problems by the window."""

from flatland_viz.drive_robots import Robot
from flatland_viz.problems import (
    Problem,
    Problems,
    frames_published_twice,
    listed,
    shared_commands,
    summary,
)

FAILED = Problem("server: plugin a/b", "switched off", True, 1, 1.0)


def test_events_are_counted_and_the_latest_comes_first():
    problems = Problems()
    problems.add("/server", "a", False, 1.0)
    problems.add("/server", "b", True, 2.0)
    problems.add("/server", "a", False, 3.0)

    assert problems.latest_first == [
        Problem("/server", "a", False, 2, 3.0),
        Problem("/server", "b", True, 1, 2.0),
    ]
    assert problems.has_errors


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


def test_events_are_forgotten_when_the_world_is_loaded_anew():
    problems = Problems()
    problems.report("d", [FAILED])
    problems.add("/server", "r22 is stuck", False, 3.0)
    problems.forget_events()
    assert problems.latest_first == [FAILED]


def test_frames_of_one_node_are_no_problem():
    assert frames_published_twice([("map", "odom", "/a"), ("odom", "base", "/a")]) == []


def test_frames_of_two_nodes_are_named():
    seen = [("map", "odom", "/server"), ("world", "odom", "/amcl"), ("odom", "base", "/server")]

    assert frames_published_twice(seen) == [
        '/amcl and /server publish the frame "odom" from "map" and "world"; switch one off'
    ]


def test_robots_with_the_same_commands_are_named():
    robots = [Robot("r1", "/cmd_vel", False), Robot("r2", "/cmd_vel", True)]

    [text] = shared_commands([*robots, Robot("r3", "/r3/cmd_vel", False)])

    assert text.startswith("r1 and r2 subscribe to /cmd_vel:")
    assert listed("abcde") == "a, b, c and 2 others"


def test_a_traceback_is_shown_by_its_exception():
    text = "the plugin failed\nTraceback (most recent call last):\n  File x\nValueError: no"

    assert summary(text) == "the plugin failed: ValueError: no"
    assert summary("two\n lines") == "two lines"
