"""Fixtures for several packages: `scripts/run` as a user starts it, a ROS master, a screen.

scripts/test runs the test files in five processes (pytest-xdist). Each has a screen of its own,
and a folder for ROS's logs.
"""

import contextlib
import functools
import gc
import itertools
import os
import re
import signal
import subprocess
import sys
import time
import xmlrpc.client
from pathlib import Path

import pytest
from ros_processes import free_port
from running_server import Master, Server
from x_server import x_server

ROOT = Path(__file__).resolve().parent


def pytest_configure(config):
    """Separates the ROS logs of test processes, since roslaunch replaces a link in the folder."""
    gc.disable()  # until the tests are collected
    worker = os.environ.get("PYTEST_XDIST_WORKER")
    if worker:
        for variable in ("ROS_HOME", "ROS_LOG_DIR"):
            os.environ[variable] = str(Path(os.environ[variable], worker))


def pytest_configure_node(node):
    """Waits until the main thread of a process is free: signals need it.

    After a task has ended, it takes the main thread some time to be ready for another one, which
    execnet gives to a new thread meanwhile.
    """
    ready = node.gateway.newchannel()
    node.gateway.remote_exec(TELL_WHEN_READY).send(ready)
    ready.receive()


TELL_WHEN_READY = """
import threading, time
def tell(ready, is_busy):
    while is_busy():
        time.sleep(0.001)
    ready.send(None)
is_busy = channel.gateway._execpool._primary_thread_task_ready.is_set
threading.Thread(target=tell, args=(channel.receive(), is_busy), daemon=True).start()
"""


MADE_FIRST = {
    "test_core.py": ("flatland_server/test/test_core.py",),
    "test_pip.py": ("flatland2d/test/pip/pip_environments.py", "library"),
    "test_pip_extras.py": ("flatland2d/test/pip/pip_environments.py", "with_ray", "with_sb3"),
    "test_ros2.py": ("flatland_bridge/test/ros2_environment.py",),
}
"""By test files: programs that compile or install what these need, below src/."""


def pytest_collection_finish(session):
    """Excludes the thousands of collected tests from garbage collection; starts `MADE_FIRST`.

    One process does for all: it makes in the background what tests have to wait for otherwise. If
    that fails, the tests say so: they make what is not there.
    """
    gc.collect()
    gc.freeze()
    gc.enable()
    if os.environ.get("PYTEST_XDIST_WORKER", "gw0") != "gw0" or session.config.option.collectonly:
        return
    paths = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    for name in {item.path.name for item in session.items} & MADE_FIRST.keys():
        program, *arguments = MADE_FIRST[name]
        command = ["nice", "-n", "5", sys.executable, str(ROOT / "src" / program), *arguments]
        making = subprocess.Popen(command, env=paths, start_new_session=True, **quiet)
        session.config.add_cleanup(functools.partial(end_group, making))


def end_group(process):
    """Ends a process that leads a group, and all in it."""
    if process.poll() is None:
        os.killpg(process.pid, signal.SIGTERM)
        process.wait()


FOLDERS = itertools.count()
"""A number for each test's folder."""


@pytest.fixture
def tmp_path(request, tmp_path_factory):
    """A folder of the test's own. pytest's own fixture lists all earlier ones for a free number."""
    name = re.sub(r"\W", "_", request.node.name)[:30]
    return tmp_path_factory.mktemp(f"{next(FOLDERS)}_{name}", numbered=False)


LONGEST = (
    *("test_gui_viewers.py", "test_gui_window.py", "test_rostests.py", "test_tutorials.py"),
    *("test_bridge_soak.py", "test_pages.py", "test_outages.py", "test_bridge_node.py"),
    *("test_in_process.py", "test_examples.py", "test_launch.py", "test_gui_scene.py"),
    *("test_example_package.py", "test_running_server.py", "test_sweeps.py", "test_contract.py"),
    *("test_sweep.py", "test_subscribers.py"),
)
"""The files that take longest; the first begin first."""


def pytest_collection_modifyitems(items):
    """Puts the longest tests first, so that all processes end at about the same time.

    Those of `MADE_FIRST` wait until the end of the slow ones for what is made meanwhile.
    """

    def order(item):
        name, is_quick = item.path.name, item.get_closest_marker("slow") is None
        place = LONGEST.index(name) if name in LONGEST else len(LONGEST)
        return is_quick, name in MADE_FIRST, place

    items.sort(key=order)


class Launch:
    """`scripts/run`, or another `command` like it, with a ROS master of its own.

    Args:
        arguments: of the command; `-p` with a free port is added if there is none.
        output: file that gets the output.
        display: the X display, such as ":51".
        command: path of the program.
        port: the master's port.
        with_port: whether `-p` is added; without, ROS_MASTER_URI says which master is used.
        environment: additional variables.
    """

    def __init__(
        self,
        *arguments,
        output,
        display=None,
        command=(str(ROOT / "scripts" / "run"),),
        port=None,
        with_port=True,
        environment=None,
    ):
        self.port = port or free_port()
        self.uri = f"http://127.0.0.1:{self.port}"
        settings = str(output.parent / "config")  # the window's
        self.environment = {**os.environ, "XDG_CONFIG_HOME": settings}
        self.environment.pop("DISPLAY", None)
        if display:
            self.environment.update(DISPLAY=display, LIBGL_ALWAYS_SOFTWARE="1")
        self.environment.update(environment or {}, ROS_MASTER_URI=self.uri)
        self._output = output
        if with_port and "-p" not in arguments:
            arguments = (*arguments, "-p", str(self.port))
        with output.open("w") as file:
            self.process = subprocess.Popen(
                [*command, *arguments],
                stdout=file,
                stderr=subprocess.STDOUT,
                stdin=subprocess.DEVNULL,
                env=self.environment,
                start_new_session=True,
                # A shell that starts us in the background has SIGINT ignored; a user's has not.
                preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
            )

    @property
    def output(self):
        return self._output.read_text()

    def wait_until(self, holds, what, limit=60.0):
        """Wait for a condition; fail if it takes too long, or if the launch ends before."""
        deadline = time.monotonic() + limit
        while not holds():
            assert self.process.poll() is None, self.output
            assert time.monotonic() < deadline, f"waited for {what}:\n{self.output}"
            time.sleep(0.02)

    def wait_for(self, text):
        """Wait for a line of output."""
        self.wait_until(lambda: text in self.output, f'"{text}"')

    def press_ctrl_c(self):
        """Sends SIGINT to all processes of the foreground group, as a terminal does."""
        os.killpg(self.process.pid, signal.SIGINT)

    def nodes(self):
        """The nodes that are registered with the master."""
        master = xmlrpc.client.ServerProxy(self.environment["ROS_MASTER_URI"])
        try:
            publishers, subscribers, services = master.getSystemState("/test_launch")[2]
        except OSError:  # not there yet
            return set()
        return {node for _, nodes in publishers + subscribers + services for node in nodes}


@contextlib.contextmanager
def launching(folder):
    """Start `scripts/run` with arguments, with output in a folder; end it with the context."""
    launches = []

    def start(*arguments, **options):
        launch = Launch(*arguments, output=folder / f"{len(launches)}.log", **options)
        launches.append(launch)
        return launch

    yield start
    for launch in launches:
        if launch.process.poll() is None:
            launch.press_ctrl_c()
            try:
                launch.process.wait(20)
            except subprocess.TimeoutExpired:
                os.killpg(launch.process.pid, signal.SIGKILL)


@pytest.fixture
def run(tmp_path):
    """Start `scripts/run` with arguments; it is ended after the test."""
    with launching(tmp_path) as start:
        yield start


@pytest.fixture(scope="module")
def run_for_module(tmp_path_factory):
    """Start `scripts/run` with arguments; it is ended after the module's tests."""
    with launching(tmp_path_factory.mktemp("launches")) as start:
        yield start


@pytest.fixture(scope="module")
def master():
    """A ROS master for the module's tests. Its start and end take 0.4 s of CPU time."""
    master = Master()
    yield master
    master.kill()


@pytest.fixture
def start_server(master, tmp_path):
    """Starts servers under the master, by options of `Server`; they are ended after the test."""
    servers = []

    def start(**options):
        servers.append(Server(master, tmp_path / f"server{len(servers)}.log", **options))
        return servers[-1]

    yield start
    for server in servers:
        server.kill()


@pytest.fixture(scope="session")
def display():
    """Name of an X server of our own, without a window manager; all tests share its screen."""
    with x_server(1400, 900) as display:
        yield display
