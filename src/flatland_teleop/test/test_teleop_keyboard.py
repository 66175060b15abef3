"""The node in a pseudo-terminal: keys are typed, and robots of a real server drive."""

import fcntl
import os
import pty
import shutil
import signal
import socket
import subprocess
import sys
import termios
import threading
import xmlrpc.client

import pytest
import tcpros_client
from nav_msgs.msg import Odometry
from ros_processes import executable
from waiting import wait_until

pytestmark = pytest.mark.slow

ROBOT = """\
bodies:
  - name: base
    footprints: [{type: circle, radius: 0.2, density: 1}]
plugins:
  - {type: DiffDrive, name: drive, body: base, pub_rate: 50}
"""
WORLD = """\
properties: {}
layers: []
models:
  - {name: r2, namespace: r2, model: robot.yaml}
  - {name: r10, namespace: r10, model: robot.yaml, pose: [0, 3, 0]}
"""


def forwards(odometry):
    """The speed of the next message on a connection [m/s]."""
    return tcpros_client.next_message(odometry, Odometry).twist.twist.linear.x


class Typist:
    """Runs the node in a terminal, and types."""

    def __init__(self, uri):
        self._master = xmlrpc.client.ServerProxy(uri)
        self.controller, self.terminal = pty.openpty()
        self.mode = termios.tcgetattr(self.terminal)
        self.shown = ""
        self._held = threading.Event()
        self.process = subprocess.Popen(
            [executable("flatland_teleop", "teleop_keyboard")],
            env={**os.environ, "ROS_MASTER_URI": uri, "TERM": "xterm"},
            stdin=self.terminal,
            stdout=self.terminal,
            stderr=self.terminal,
            start_new_session=True,
            preexec_fn=lambda: fcntl.ioctl(self.terminal, termios.TIOCSCTTY, 0),
        )
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self):
        while True:
            try:
                self.shown += os.read(self.controller, 4096).decode()
            except OSError:
                return

    def type(self, keys):
        os.write(self.controller, keys.encode())

    def hold(self, key):
        """Types a key again and again, as a terminal does, until the returned event is set."""
        released = threading.Event()

        def repeat():
            while not released.wait(0.03):
                self.type(key)

        self.type(key)
        threading.Thread(target=repeat, daemon=True).start()
        return released

    def wait_for_speed(self, topic, low, high):
        uri = self._master.lookupNode("/test", "/flatland_server")[2]
        with tcpros_client.subscribe(uri, topic, Odometry) as odometry:
            wait_until(lambda: low <= forwards(odometry) <= high, f"{low} to {high} m/s on {topic}")


@pytest.fixture
def typist(run, tmp_path):
    (tmp_path / "robot.yaml").write_text(ROBOT)
    (tmp_path / "world.yaml").write_text(WORLD)
    launch = run(
        "flatland_server",
        "server.launch",
        "show_viz:=false",
        f"world_path:={tmp_path / 'world.yaml'}",
        command=(sys.executable, shutil.which("roslaunch")),
    )
    launch.wait_for("running")
    typist = Typist(launch.uri)
    launch.wait_until(lambda: "/r2/cmd_vel" in typist.shown, "the keys to be shown")
    yield typist
    if typist.process.poll() is None:
        os.killpg(typist.process.pid, signal.SIGKILL)


def test_robots_drive_while_a_key_is_held_and_stop_after_it(typist):
    key = typist.hold("w")
    typist.wait_for_speed("/r2/odometry/filtered", 0.49, 0.51)
    key.set()
    typist.wait_for_speed("/r2/odometry/filtered", -0.01, 0.01)

    typist.type("\t+")
    typist.type("\x1b[1;1:1B")  # "down", in a terminal that reports releases
    typist.wait_for_speed("/r10/odometry/filtered", -0.56, -0.54)
    typist.type("\t")
    typist.wait_for_speed("/r10/odometry/filtered", -0.01, 0.01)

    typist.type("\x1b[1;1:1B")
    typist.wait_for_speed("/r2/odometry/filtered", -0.56, -0.54)
    typist.type("\x03")  # Ctrl-C: the terminal sends SIGINT
    assert typist.process.wait(30) == 0
    typist.wait_for_speed("/r2/odometry/filtered", -0.01, 0.01)
    assert termios.tcgetattr(typist.terminal) == typist.mode
    assert "Traceback" not in typist.shown


def test_ctrl_c_while_waiting_for_the_master_has_no_traceback():
    with socket.socket() as silent:  # accepts connections, and never answers
        silent.bind(("127.0.0.1", 0))
        silent.listen()
        silent.settimeout(60)
        controller, terminal = pty.openpty()
        process = subprocess.Popen(
            [executable("flatland_teleop", "teleop_keyboard")],
            stdin=terminal,
            stdout=terminal,
            stderr=subprocess.PIPE,
            env={**os.environ, "ROS_MASTER_URI": f"http://127.0.0.1:{silent.getsockname()[1]}"},
        )
        connection, _ = silent.accept()
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=60)
        connection.close()
    os.close(controller)
    os.close(terminal)
    assert process.returncode == -signal.SIGINT
    assert b"Traceback" not in errors


def test_without_a_terminal_it_says_how_to_give_it_one():
    result = subprocess.run(
        [executable("flatland_teleop", "teleop_keyboard")],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=60,
    )
    assert result.returncode == 1
    assert 'launch-prefix="xterm -e"' in result.stdout
