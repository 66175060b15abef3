"""Launching the simulator as a user does: scripts/run, a wrong world, Ctrl-C."""

import os
import re
import shutil
import signal
import socketserver
import subprocess
import sys
import threading
import time
import xmlrpc.client
from pathlib import Path

import pytest
import tcpros_client
from flatland_msgs.msg import SimulationState
from ros_processes import executable, processes_under
from rosgraph_msgs.msg import Clock
from tcpros_client import next_message
from waiting import wait_until

ROOT = Path(__file__).resolve().parents[3]
ROOM = ROOT / "src" / "flatland_server" / "worlds" / "test_room"
FAULTY_PLUGINS = ROOT / "src" / "flatland_server" / "test" / "faulty_plugins"
ERROR = re.compile(r"\[FATAL\] \[[^]]*\]: (.*)")

pytestmark = pytest.mark.slow


@pytest.fixture
def run_at_master(run, master):
    """Starts `scripts/run` with arguments at a ROS master that is there."""
    return lambda *arguments: run(*arguments, with_port=False, port=master.port)


def test_without_a_display_it_runs_until_ctrl_c(run):
    launch = run("--sigint-timeout=60")  # the time after which roslaunch escalates
    launch.wait_for("running")
    launch.wait_for("no display")

    lines = [line for line in launch.output.splitlines() if "display" in line]
    assert len(lines) == 1
    assert "[WARN]" in lines[0]
    assert "/flatland_server" in launch.nodes()
    assert processes_under(launch.uri)

    launch.press_ctrl_c()

    assert launch.process.wait(60) == 0, launch.output
    assert "Traceback" not in launch.output
    assert "escalating" not in launch.output
    assert processes_under(launch.uri) == []


def uri_of_server(master_uri):
    master = xmlrpc.client.ServerProxy(master_uri)
    return master.lookupNode("/test_launch", "/flatland_server")[2]


def pid_of_server(master_uri):
    """None if no server answers; one that ended while it was loading stays known to the master."""
    try:
        return xmlrpc.client.ServerProxy(uri_of_server(master_uri)).getPid("/test_launch")[2]
    except OSError:
        return None


@pytest.fixture(scope="module")
def many_robots(tmp_path_factory):
    """A world that takes a second to load."""
    robot = ROOT / "src" / "flatland_server" / "worlds" / "office" / "turtlebot.model.yaml"
    models = "".join(
        f"  - {{name: r{i}, namespace: r{i}, model: {robot}, pose: [{i}, 0, 0]}}\n"
        for i in range(200)
    )
    world = tmp_path_factory.mktemp("many_robots") / "many.yaml"
    world.write_text(f"properties: {{}}\nlayers: []\nmodels:\n{models}")
    return world


def test_ctrl_c_while_the_world_is_loading_ends_it_too(run_at_master, many_robots):
    """Rospy's own signal handler could wait for a lock of the thread that it interrupted."""
    launch = run_at_master(str(many_robots), "show_viz:=false", "--sigint-timeout=60")
    launch.wait_until(lambda: pid_of_server(launch.uri), "the server to register")
    time.sleep(0.3)

    launch.press_ctrl_c()

    assert launch.process.wait(60) == 0, launch.output
    assert "escalating" not in launch.output
    assert processes_under(launch.uri) == []


@pytest.mark.parametrize("delay", [0.0, 0.15, 0.6])
def test_ctrl_c_in_other_phases_of_loading_ends_the_server(master, many_robots, delay):
    server = subprocess.Popen(
        [
            *(executable("flatland_server", "flatland_server"), "__name:=flatland_server"),
            *(f"_world_path:={many_robots}", "_show_viz:=false"),
        ],
        env={**os.environ, "ROS_MASTER_URI": master.uri},
    )
    try:
        wait_until(lambda: pid_of_server(master.uri) == server.pid, "the server to register")
        time.sleep(delay)

        server.send_signal(signal.SIGINT)

        assert server.wait(60) in (0, -signal.SIGINT)
    finally:
        server.kill()
        server.wait()


def may_have_real_time_priority():
    """Tries it in a process of its own, since this thread must not have that priority."""
    code = "import os; os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(1))"
    result = subprocess.run([sys.executable, "-c", code], stderr=subprocess.DEVNULL)
    return result.returncode == 0


def test_an_endless_plugin_loses_its_priority_and_ctrl_c_ends_it(run, tmp_path, monkeypatch):
    for name in ("ROS_PACKAGE_PATH", "PYTHONPATH"):  # scripts/run would set them again
        monkeypatch.setenv(name, f"{FAULTY_PLUGINS}:{os.environ[name]}")
    (tmp_path / "robot.yaml").write_text(
        "bodies: [{name: base, footprints: [{type: circle, radius: 0.2, density: 10}]}]\n"
        "plugins: [{type: NeverReturns, name: looper}]\n"
    )
    world = tmp_path / "world.yaml"
    world.write_text("properties: {}\nlayers: []\nmodels: [{name: robot, model: robot.yaml}]\n")
    launch = run(
        *("flatland_server", "server.launch", f"world_path:={world}", "show_viz:=false"),
        "--sigint-timeout=60",
        command=(sys.executable, shutil.which("roslaunch")),
    )
    launch.wait_for("running")
    launch.wait_for('held up for more than 1 s by the plugin "robot/looper"')
    pid = pid_of_server(launch.uri)
    if may_have_real_time_priority():
        launch.wait_for("has lost its real-time priority")  # a second after it was held up
        assert 'the plugin "robot/looper"' in launch.output
        assert os.sched_getscheduler(pid) == os.SCHED_OTHER

    launch.press_ctrl_c()
    launch.process.wait(60)

    assert "the current step does not end: the process exits within the plugin" in launch.output
    assert "escalating" not in launch.output
    assert processes_under(launch.uri) == []


def test_a_missing_world_ends_with_one_line_and_an_error_code(run_at_master, tmp_path):
    missing = tmp_path / "missing.yaml"
    launch = run_at_master(f"world_path:={missing}", "show_viz:=false")

    assert launch.process.wait(60) == 1
    errors = ERROR.findall(launch.output)
    assert errors == [f"{missing}: cannot be read: No such file or directory"]
    assert "Traceback" not in launch.output


def test_a_wrong_world_is_named_with_line_and_reason(run_at_master, tmp_path):
    world = tmp_path / "world.yaml"
    world.write_text("properties: {}\nlayers: []\nmodels:\n  - name: a\n    pose: foo\n")
    launch = run_at_master(str(world), "show_viz:=false")

    assert launch.process.wait(60) == 1
    errors = ERROR.findall(launch.output)
    assert errors == [
        f'{world}:5: models[0].pose: expected [x, y, yaw], found "foo"',
        f'{world}:4: models[0] "a": the required key "model" is missing',
    ]
    assert launch.output.splitlines()[-1].endswith('the required key "model" is missing')
    assert "Traceback" not in launch.output


def test_a_wrong_argument_is_named(run_at_master):
    launch = run_at_master(
        str(ROOM / "world.yaml"), "step_size:=inf", "show_viz:=true", "use_rviz:=true"
    )

    assert launch.process.wait(60) == 1
    assert ERROR.findall(launch.output) == ["~step_size: expected a number above 0, found inf"]


def test_an_unknown_argument_is_named(run):
    launch = run(str(ROOM / "world.yaml"), "udpate_rate:=100", "show_viz:=false")

    assert launch.process.wait(60) == 1
    assert launch.output.startswith(
        'run: server.launch has no argument "udpate_rate" (did you mean "update_rate"?); it has: '
    )
    assert len(launch.output.splitlines()) == 1


def test_a_taken_port_is_one_line(run):
    with socketserver.TCPServer(("127.0.0.1", 0), socketserver.BaseRequestHandler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        port = server.server_address[1]
        launch = run("show_viz:=false", "-p", str(port))
        code = launch.process.wait(60)
        server.shutdown()

    assert code == 1
    assert launch.output == (
        f"run: port {port} is taken by a program that is no ROS master: choose one by -p\n"
    )


@pytest.fixture(scope="module")
def room(run_for_module):
    """A shipped world, by name; rate, step size and their product differ from the defaults."""
    launch = run_for_module("test_room", "update_rate:=100", "step_size:=0.02", "show_viz:=false")
    launch.wait_for("test_room/world.yaml: ")
    launch.wait_for("running")
    return launch


def test_the_master_of_another_run_is_one_line(run, room):
    own = run("show_viz:=false", "-p", str(room.port))
    shared = run("show_viz:=false", with_port=False, port=room.port)

    assert own.process.wait(60) == 1
    assert own.output.startswith(f"run: port {room.port} has the ROS master of another run: ")
    assert shared.process.wait(60) == 1
    assert shared.output.startswith(f"run: a simulation is running at {room.uri}: end it, or ")
    assert len((own.output + shared.output).splitlines()) == 2
    assert room.process.poll() is None


def test_time_goes_at_update_rate_times_step_size(room):
    """In steps of 20 ms; test_pacer.py paces them by a clock of its own."""
    server = uri_of_server(room.uri)
    with tcpros_client.subscribe(server, "/flatland_server/state", SimulationState) as states:
        assert next_message(states, SimulationState).rate == 2.0
    with tcpros_client.subscribe(server, "/clock", Clock) as clock:
        times = [next_message(clock, Clock).clock.to_nsec() for _ in range(10)]
    assert sorted(set(times)) == times
    assert {time % 20_000_000 for time in times} == {0}
