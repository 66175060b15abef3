"""Arguments that a launch file does not have, which roslaunch ignores, are refused."""

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

from flatland_server.exceptions import FlatlandError
from flatland_server.ros.launch_arguments import check_launch_arguments, parent_command_line

SRC = Path(__file__).resolve().parents[3]
SERVER = SRC / "flatland_server/launch/server.launch"
BENCHMARK = SRC / "flatland_benchmark/launch/benchmark.launch"
SERVERS_BENCHMARK = SRC / "flatland_server/launch/benchmark.launch"
ROSLAUNCH = ["/usr/bin/python3", "/usr/bin/roslaunch", "-p", "11322"]


def refusal(files, *words):
    with pytest.raises(FlatlandError) as caught:
        check_launch_arguments(files, [*ROSLAUNCH, *words])
    return str(caught.value)


@pytest.mark.parametrize("started", [("flatland_server", "server.launch"), (str(SERVER),)])
def test_an_unknown_argument_is_named_with_suggestions(started):
    assert refusal([SERVER], *started, "world_path:=/a.yaml", "udpate_rate:=inf") == (
        'server.launch has no argument "udpate_rate" (did you mean "update_rate"?); it has: '
        "world_path, update_rate, step_size, control_period, train_mode, show_viz, viz_pub_rate, "
        "use_rviz, history, command_age, models, state_folder, seed, simplify_map, no_return, "
        "static_tf, tf_by_namespace, wall_clock_stamps, realtime_priority, map_to_odom, "
        "map, odom_topic, initial_pose"
    )


def test_the_documented_arguments_have_their_documented_defaults():
    """The documentation lists them under "Launching Flatland Server Node"."""
    arguments = {
        each.get("name"): each.get("default") for each in ElementTree.parse(SERVER).iter("arg")
    }

    assert arguments.pop("world_path") is not None
    documented = ("update_rate", "step_size", "show_viz", "viz_pub_rate", "use_rviz")
    assert [arguments[name] for name in documented] == ["200.0", "0.005", "true", "30.0", "false"]


@pytest.mark.parametrize("package", ["flatland_benchmark", "flatland_server"])
def test_passed_through_arguments_of_a_launch_file_are_known(package):
    files = [BENCHMARK, SERVERS_BENCHMARK]
    started = (package, "benchmark.launch")

    check_launch_arguments(files, [*ROSLAUNCH, *started, "world_path:=/a.yaml"])
    assert refusal(files, *started, "worlds:=1").startswith('benchmark.launch has no argument "wor')


@pytest.mark.parametrize(
    "words",
    [
        ("flatland_server", "server.launch"),
        ("flatland_server", "server.launch", "seed:=3", "__log:=/tmp/a", "_seed:=3"),
        ("my_package", "server.launch", "robots:=3"),
        ("my_package", "demo.launch", "robots:=3"),
        ("/other/server.launch", "robots:=3"),
        ("flatland_server", "server.launch", "/other/demo.launch", "robots:=3"),
        ("robots:=3",),
    ],
)
def test_known_arguments_and_other_launch_files_are_accepted(words):
    check_launch_arguments([SERVER], [*ROSLAUNCH, *words])


def test_the_command_line_of_the_parent_is_read():
    words = parent_command_line()

    assert words
    assert all(words)
