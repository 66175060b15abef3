"""A virtual screen with mouse, keyboard and screenshots, and ROS programs on it.

A module has one launch: starting rviz takes longer than most tests.
"""

import json
import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from PIL import ImageGrab
from ros_processes import free_port

ROOT = Path(__file__).resolve().parents[3]
SHOTS = ROOT / "build" / "screenshots"
OFFICE = ROOT / "src" / "flatland_server" / "worlds" / "office"
LIMIT = 60.0  # s: a busy machine may take much longer than an idle one


def wait_until(holds, what, limit=LIMIT):
    """The first true value of `holds()`."""
    deadline = time.monotonic() + limit
    while True:
        value = holds()
        if value:
            return value
        assert time.monotonic() < deadline, f"waited {limit:g} s for {what}"
        time.sleep(0.05)


class Screen:
    """An X display, controlled by xdotool.

    Args:
        display: its name.
    """

    def __init__(self, display):
        self.environment = {**os.environ, "DISPLAY": display, "LIBGL_ALWAYS_SOFTWARE": "1"}

    def picture(self, name):
        """A screenshot, kept as a file: colours of shape (height, width, 3)."""
        SHOTS.mkdir(parents=True, exist_ok=True)
        path = SHOTS / f"gui_{name}.png"
        picture = ImageGrab.grab(xdisplay=self.environment["DISPLAY"])
        picture.save(path, compress_level=1)
        return np.asarray(picture).astype(int)

    def xdotool(self, *arguments):
        """Runs xdotool for mouse, keyboard or windows. Returns the words of its output."""
        command = ["xdotool", *map(str, arguments)]
        return subprocess.run(
            command, env=self.environment, stdout=subprocess.PIPE, text=True
        ).stdout.split()

    def text(self, *command):
        """The lines that a program prints."""
        return subprocess.run(
            list(map(str, command)), env=self.environment, stdout=subprocess.PIPE, text=True
        ).stdout.splitlines()

    def windows(self, title):
        """The visible windows with this title."""
        return self.xdotool("search", "--onlyvisible", "--name", f"^{title}$")

    def wait_for_window(self, title):
        window = wait_until(lambda: self.windows(title), f"the window {title!r}")[-1]
        self.focus(window)
        return window

    def wait_until_closed(self, title):
        wait_until(lambda: not self.windows(title), f"the window {title!r} to close")

    def focus(self, window):
        """Gives a window the keyboard, as a window manager does."""
        self.xdotool("windowfocus", "--sync", window)

    def key(self, *keys):
        self.xdotool("key", "--delay", 40, *keys)

    def type(self, text):
        self.xdotool("type", "--delay", 3, "--", text)

    def click(self, pixel, button=1):
        self.move(pixel)
        self.xdotool("click", button)
        time.sleep(0.2)

    def move(self, pixel):
        """In two steps: rviz determines what is under the mouse when it moves."""
        x, y = map(int, pixel)
        self.xdotool("mousemove", x - 2, y, "sleep", 0.1, "mousemove", x, y, "sleep", 0.1)

    def drag(self, pixels, while_held=lambda: None):
        """With the left button, along some pixels."""
        self.move(pixels[0])
        time.sleep(0.3)
        self.xdotool("mousedown", 1)
        for x, y in pixels:
            self.xdotool("mousemove", round(x), round(y), "sleep", 0.05)
        try:
            while_held()
        finally:
            self.xdotool("mouseup", 1)


class Ros:
    """A ROS master, programs that use it, and a node that queries them.

    Attributes:
        frame_rate: how often the window draws [Hz]. Without a graphics card each frame takes much
            of a core.
    """

    frame_rate = 5

    def __init__(self, environment, logs):
        port = free_port()
        self._logs = logs
        self._programs = []
        self.environment = {
            **environment,
            "ROS_MASTER_URI": f"http://127.0.0.1:{port}",
            "ROS_IP": "127.0.0.1",
            "XDG_CONFIG_HOME": str(logs / "config"),  # the window's settings
        }
        self.start("rosmaster", "--core", "-p", port)
        # Before any node starts: a node that finds it unset uses real time.
        wait_until(
            lambda: self._run("rosparam", "set", "/use_sim_time", "true").returncode == 0,
            "the master",
        )
        self._run("rosparam", "set", "/flatland_viz/frame_rate", str(self.frame_rate))
        self._probe = subprocess.Popen(
            [sys.executable, Path(__file__).with_name("ros_probe.py")],
            env=self.environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert self._probe.stdout.readline() == "ready\n"

    def _run(self, *command):
        return subprocess.run(
            command, env=self.environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )

    def close(self):
        self._probe.kill()
        self._probe.wait()
        for program in reversed(self._programs):
            self.end(program)

    def start(self, *command):
        """Start a program; its output goes to a file."""
        log = self._logs / f"{len(self._programs)}_{Path(command[0]).name}.log"
        with log.open("w") as file:
            program = subprocess.Popen(
                list(map(str, command)),
                env=self.environment,
                stdin=subprocess.DEVNULL,
                stdout=file,
                stderr=subprocess.STDOUT,
                start_new_session=True,
                # A shell that starts pytest in the background has SIGINT ignored; a user's has not.
                preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
            )
        self._programs.append(program)
        return program

    def log(self, program):
        """What a program has written so far."""
        return next(self._logs.glob(f"{self._programs.index(program)}_*.log")).read_text()

    def launch_server(self, world, *arguments):
        """Run server.launch; returns when the simulation runs."""
        program = self.start(
            *("roslaunch", "--sigint-timeout=1.5", "--sigterm-timeout=0.3", "--skip-log-check"),
            *("flatland_server", "server.launch", f"world_path:={world}", *arguments),
        )
        self.wait_for_clock(program)
        return program

    def wait_for_clock(self, program):
        """Wait until the simulation started by a program runs."""

        def has_come():
            assert program.poll() is None, [log.read_text() for log in self._logs.glob("*.log")]
            return self.message("/clock", "rosgraph_msgs/Clock", timeout=1)

        wait_until(has_come, "the server to run")

    def end(self, program, number=signal.SIGINT):
        if program.poll() is None:
            os.killpg(program.pid, number)
            try:
                program.wait(15)
            except subprocess.TimeoutExpired:
                os.killpg(program.pid, signal.SIGKILL)
                program.wait()

    def _ask(self, *request):
        self._probe.stdin.write(json.dumps(request) + "\n")
        self._probe.stdin.flush()
        return json.loads(self._probe.stdout.readline())

    def message(self, topic, kind, timeout=5):
        """The next message of a topic, or its latched one; None if there is none."""
        return self._ask("message", topic, kind, timeout)

    def call(self, service, **arguments):
        return self._ask("call", service, [arguments] if arguments else [])

    def state(self):
        return self.message("/flatland_server/state", "flatland_msgs/SimulationState")

    def clock(self):
        """Simulated time [s]."""
        return self.message("/clock", "rosgraph_msgs/Clock")["clock"]

    def models(self):
        """The names of the models in the world."""
        topics = self.message("/flatland_server/debug/topics", "flatland_msgs/DebugTopicList")
        return [topic[6:] for topic in topics["topics"] if topic.startswith("model/")]

    def pose(self, model):
        """Position [m] and yaw [rad] of the model's first marker."""
        topic = f"/flatland_server/debug/model/{model}"
        markers = self.message(topic, "visualization_msgs/MarkerArray")
        pose = next(m for m in markers["markers"] if m["action"] == 0)["pose"]
        rotation = pose["orientation"]
        yaw = 2 * math.atan2(rotation["z"], rotation["w"])
        return pose["position"]["x"], pose["position"]["y"], yaw

    def spawn(self, file, name, x, y, theta=0.0):
        pose = {"x": x, "y": y, "theta": theta}
        answer = self.call("/spawn_model", yaml_path=str(file), name=name, ns="", pose=pose)
        assert answer["success"], answer["message"]


@pytest.fixture(scope="module")
def screen(display):
    return Screen(display)


@pytest.fixture(scope="module")
def ros(screen, tmp_path_factory):
    ros = Ros(screen.environment, tmp_path_factory.mktemp("ros"))
    yield ros
    ros.close()


@pytest.fixture(scope="module")
def waiting():
    """`wait_until`, as tests use it."""
    return wait_until


@pytest.fixture(scope="module")
def office():
    """The folder of the office world."""
    return OFFICE
