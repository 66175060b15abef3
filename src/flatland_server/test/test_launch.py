"""The main job, as a user does it: scripts/run, a wrong world, Ctrl-C."""

import re
import subprocess
import time
from pathlib import Path

import pytest
from ros_processes import processes_under

ROOT = Path(__file__).resolve().parents[3]
ROOM = ROOT / "src" / "flatland_server" / "worlds" / "test_room"
ERROR = re.compile(r"\[FATAL\] \[[^]]*\]: (.*)")

pytestmark = pytest.mark.slow


def test_without_a_display_it_says_so_and_goes_on(run):
    launch = run()
    launch.wait_for("running")
    launch.wait_for("no display")

    lines = [line for line in launch.output.splitlines() if "display" in line]
    assert len(lines) == 1
    assert "[WARN]" in lines[0]
    assert "/flatland_server" in launch.nodes()


def test_ctrl_c_ends_everything_quietly(run):
    launch = run()
    launch.wait_for("running")
    assert processes_under(launch.uri)

    begin = time.monotonic()
    launch.press_ctrl_c()
    code = launch.process.wait(20)
    seconds = time.monotonic() - begin

    assert code == 0, launch.output
    assert seconds < 3.0, launch.output
    assert "Traceback" not in launch.output
    assert "escalating" not in launch.output
    assert processes_under(launch.uri) == []


@pytest.mark.parametrize("delay", [0.0, 0.15, 0.3, 0.6])
def test_ctrl_c_while_the_world_is_loading_ends_it_too(run, tmp_path, delay):
    """Rospy's own signal handler could meet itself on a lock that a spawn held."""
    robot = ROOT / "src" / "flatland_server" / "worlds" / "office" / "turtlebot.model.yaml"
    models = "".join(
        f"  - {{name: r{i}, namespace: r{i}, model: {robot}, pose: [{i}, 0, 0]}}\n"
        for i in range(200)
    )
    world = tmp_path / "many.yaml"
    world.write_text(f"properties: {{}}\nlayers: []\nmodels:\n{models}")
    launch = run(str(world), "show_viz:=false")
    launch.wait_until(lambda: "/flatland_server" in launch.nodes(), "the server to register")
    time.sleep(delay)  # another moment of loading each time

    launch.press_ctrl_c()

    assert launch.process.wait(20) == 0, launch.output
    assert "escalating" not in launch.output
    assert processes_under(launch.uri) == []


def test_a_missing_world_ends_with_one_line_and_an_error_code(run, tmp_path):
    missing = tmp_path / "missing.yaml"
    launch = run(f"world_path:={missing}", "show_viz:=false")

    assert launch.process.wait(60) == 1
    errors = ERROR.findall(launch.output)
    assert errors == [f"{missing}: cannot be read: No such file or directory"]
    assert "Traceback" not in launch.output


def test_a_wrong_world_is_named_with_line_and_reason(run, tmp_path):
    world = tmp_path / "world.yaml"
    world.write_text("properties: {}\nlayers: []\nmodels:\n  - name: a\n    pose: foo\n")
    launch = run(str(world), "show_viz:=false")

    assert launch.process.wait(60) == 1
    errors = ERROR.findall(launch.output)
    assert errors == [
        f'{world}:5: models[0].pose: expected [x, y, yaw], found "foo"',
        f'{world}:4: models[0] "a": the required key "model" is missing',
    ]
    assert "Traceback" not in launch.output


@pytest.mark.parametrize(
    ("argument", "message"),
    [
        ("update_rate:=0", "~update_rate: expected a number above 0, found 0"),
        ("update_rate:=fast", "~update_rate: expected a number above 0, found fast"),
        ("step_size:=-0.005", "~step_size: expected a number above 0, found -0.005"),
        ("step_size:=inf", "~step_size: expected a number above 0, found inf"),
        ("viz_pub_rate:=nan", "~viz_pub_rate: expected a number above 0, found nan"),
        ("seed:=-1", "~seed: expected a whole number of 0 or more, found -1"),
    ],
)
def test_a_wrong_argument_is_named(run, argument, message):
    launch = run(str(ROOM / "world.yaml"), argument, "show_viz:=true", "use_rviz:=true")

    assert launch.process.wait(60) == 1
    assert ERROR.findall(launch.output) == [message]


@pytest.mark.parametrize(("update_rate", "factor"), [("400", 2.0), ("100", 0.5)])
def test_time_goes_at_update_rate_times_step_size(run, update_rate, factor):
    launch = run(
        str(ROOM / "world.yaml"),
        f"update_rate:={update_rate}",
        "step_size:=0.005",
        "show_viz:=false",
    )
    launch.wait_for("running")

    listen = (
        "import rospy, sys, time\n"
        "from rosgraph_msgs.msg import Clock\n"
        "rospy.init_node('listener', disable_rostime=True)\n"
        "clock = lambda: rospy.wait_for_message('/clock', Clock, 20).clock.to_sec()\n"
        "a, begin = clock(), time.monotonic()\n"
        "time.sleep(4)\n"
        "print((clock() - a) / (time.monotonic() - begin))\n"
    )
    result = subprocess.run(
        ["/usr/bin/python3", "-c", listen],
        env=launch.environment,
        stdout=subprocess.PIPE,
        text=True,
        timeout=60,
        check=True,
    )
    assert float(result.stdout) == pytest.approx(factor, rel=0.03)
