"""Shared by the tests of the guide: a ROS master, and the environment of a reader."""

import contextlib
import os
import subprocess
import xmlrpc.client

import pytest
from blocks import blocks_of
from page_run import PageRun
from ros_processes import executable, free_port
from waiting import wait_until

MODULES = {"training.md": "gymnasium"}
"""The module that a whole page needs, by page."""


def needs_master(page):
    return any(block.uses_ros and not block.note("not run:") for block in blocks_of(page))


@pytest.fixture(scope="module")
def master():
    """A ROS master that the pages share, one after the other."""
    port = free_port()
    process = subprocess.Popen(
        ["rosmaster", "--core", "-p", str(port)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    proxy = xmlrpc.client.ServerProxy(f"http://127.0.0.1:{port}")

    def answers():
        with contextlib.suppress(OSError):
            return bool(proxy.getPid("/guide"))
        return False

    wait_until(answers, "the ROS master", 30.0)
    yield proxy, f"http://127.0.0.1:{port}"
    process.terminate()
    process.wait(10)


@pytest.fixture
def environment(tmp_path_factory):
    """A reader's environment: a home, the workspace, and the tutorials' command `flatland`."""
    home = tmp_path_factory.mktemp("home")
    (home / "flatland").symlink_to(executable("flatland2d", "flatland"))
    path = f"{home}:{os.environ['PATH']}"
    return {**os.environ, "HOME": str(home), "ROS_HOME": str(home / "ros"), "PATH": path}


@pytest.fixture
def run_page(tmp_path, environment, request):
    """Runs a page in an empty folder, with a ROS master if it needs one."""

    def run(page):
        if page.name in MODULES:
            pytest.importorskip(MODULES[page.name])
        if needs_master(page):
            proxy, uri = request.getfixturevalue("master")
            environment["ROS_MASTER_URI"] = uri
            for parameter in proxy.getParamNames("/guide")[2]:  # of the page before
                if parameter not in ("/run_id", "/rosdistro", "/rosversion"):
                    proxy.deleteParam("/guide", parameter)
        PageRun(page, tmp_path, environment).run()

    return run
