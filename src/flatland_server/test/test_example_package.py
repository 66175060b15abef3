"""Copies of flatland_example_plugins as a user's packages: in a workspace on an installed Flatland.

Flatland, the example package included, is installed out of the clone's build folder, below a
DESTDIR, as packagers do it: setup.bash finds an install space where it lies. The user's workspace
is a new one each time, with one copy under the same name and one renamed as the README says.
"""

import os
import re
import shutil
import signal
import subprocess
import tempfile
from pathlib import Path

import pytest
import tcpros_client
from catkin_pkg.packages import find_packages
from commands import run
from std_msgs.msg import Int32
from tcpros_client import next_message
from waiting import wait_until

ROOT = Path(__file__).resolve().parents[3]
BUILD = ROOT / "build"
PACKAGE = ROOT / "src" / "flatland_example_plugins"

LIMIT = 300.0  # s of real time, for each command; other builds may be running
CONFIGURE = "-DPYTHON_EXECUTABLE=/usr/bin/python3 -DCMAKE_BUILD_TYPE=Release"

COPIES = ("flatland_example_plugins", "my_plugins")

# Of a workspace's devel space and of its install space: where packages are, how one is launched.
FOLDERS = {"devel": "src", "install": "install/share"}
LAUNCH_FILES = {
    "devel": "flatland_server server.launch "
    '"world_path:=$(rospack find my_plugins)/worlds/conveyor/world.yaml"',
    "install": "my_plugins conveyor.launch",
}

WHERE_FOUND = """
import inspect
from flatland_server import ModelPlugin, PluginLoader
for name in ("Simple", "flatland_example_plugins::Simple"):
    found = PluginLoader().load(name, ModelPlugin)
    print(found.__module__, inspect.getfile(found))
"""

pytestmark = pytest.mark.slow


class Shell:
    """A user's bash in which nothing is sourced yet.

    Args:
        home: its folder.
        master_uri: of the ROS master; by default there is none.
    """

    def __init__(self, home, master_uri="http://127.0.0.1:9"):
        self.environment = {
            "PATH": "/usr/bin:/bin",
            "HOME": str(home),
            "LANG": "C.UTF-8",
            "PYTHONUNBUFFERED": "1",
            "ROS_IP": "127.0.0.1",
            "ROS_MASTER_URI": master_uri,
        }

    def run(self, *commands):
        """Run commands, and return their output; the first that fails fails the test."""
        return run("bash", "-c", " && ".join(commands), env=self.environment, timeout=LIMIT)

    def start(self, *commands, output):
        """Run commands in a session of their own, with a file for their output."""
        return subprocess.Popen(
            ["bash", "-c", " && ".join(commands)],
            env=self.environment,
            stdout=output,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )


@pytest.fixture
def shell(tmp_path):
    return Shell(tmp_path)


@pytest.fixture(scope="module")
def flatland(tmp_path_factory):
    """The install space of a Flatland with the example package."""
    folder = tmp_path_factory.mktemp("flatland")
    cache = (BUILD / "CMakeCache.txt").read_text()
    [prefix] = re.findall(r"^CMAKE_INSTALL_PREFIX:PATH=/(.*)$", cache, flags=re.MULTILINE)
    packages = ("flatland2d", "flatland_msgs", "flatland_plugins", "flatland_server", PACKAGE.name)
    Shell(folder).run(
        f"export DESTDIR='{folder}'",
        f"cmake -DCMAKE_INSTALL_LOCAL_ONLY=1 -P '{BUILD}/cmake_install.cmake'",  # setup.bash etc.
        *(f"cmake -P '{BUILD}/src/{package}/cmake_install.cmake'" for package in packages),
    )
    return folder / prefix


def test_a_cpp_plugin_ends_its_build_with_a_hint(flatland, tmp_path):
    (tmp_path / "CMakeLists.txt").write_text("""
cmake_minimum_required(VERSION 3.10)
project(cpp_plugins)
find_package(catkin REQUIRED COMPONENTS flatland_server)
include_directories(${catkin_INCLUDE_DIRS})
add_library(cpp_plugins plugin.cpp)
""")
    (tmp_path / "plugin.cpp").write_text("#include <flatland_server/model_plugin.h>")
    with pytest.raises(pytest.fail.Exception, match=r"docs/coming_from_cpp.md says how to port"):
        Shell(tmp_path).run(
            f"source '{flatland}/setup.bash'",
            f"cmake {CONFIGURE} -S '{tmp_path}' -B '{tmp_path}/build'",
            f"cmake --build '{tmp_path}/build'",
        )


def rename(copy):
    """Give a copy of the package the name of its folder, as the package's README says."""
    (copy / "src" / PACKAGE.name).rename(copy / "src" / copy.name)
    for file in copy.rglob("*"):
        if file.is_file():
            file.write_text(file.read_text().replace(PACKAGE.name, copy.name))


@pytest.fixture(scope="module")
def workspace(flatland):
    """A catkin workspace with the copies alone, built and installed.

    It is always below /tmp: catkin cannot install Python packages from a folder with a space.
    """
    folder = Path(tempfile.mkdtemp(dir="/tmp", prefix="workspace_"))
    shell = Shell(folder)
    ignored = shutil.ignore_patterns("__pycache__")
    for name in COPIES:
        shutil.copytree(PACKAGE, folder / "src" / name, ignore=ignored)
    rename(folder / "src" / "my_plugins")
    shell.run(
        f"source '{flatland}/setup.bash'", f"cd '{folder}'", f"catkin_make {CONFIGURE} install"
    )
    yield folder
    shutil.rmtree(folder)


def test_an_install_space_within_a_source_space_is_not_crawled(flatland, shell):
    """As in the clone itself, after `catkin_make --source . install`."""
    within = shell.run(f"ROS_PACKAGE_PATH='{flatland.parent}' rospack list-names")
    itself = shell.run(f"source '{flatland}/setup.bash'", "rospack list-names").split()

    assert "flatland" not in within
    assert find_packages(str(flatland.parent)) == {}
    assert {"flatland_msgs", "flatland_plugins", "flatland_server"} <= set(itself)


def test_type_checkers_see_the_installed_packages(flatland):
    for package in ("flatland2d", "flatland_plugins", "flatland_server"):
        [marker] = (flatland / "lib").glob(f"python3*/*-packages/{package}/py.typed")
    assert (marker.parent / "_core.pyi").is_file()


@pytest.mark.parametrize("space", ["devel", "install"])
def test_rospack_lists_its_plugins(workspace, flatland, shell, space):
    setup = f"source '{workspace}/{space}/setup.bash'"

    plugins = shell.run(setup, "rospack plugins --attrib=plugin flatland_server").splitlines()
    server = shell.run(setup, "rospack find flatland_server").strip()

    installed = flatland / "share"
    assert sorted(plugins) == [
        f"flatland_example_plugins {workspace / FOLDERS[space]}/flatland_example_plugins/"
        "flatland_plugins.xml",
        f"flatland_plugins {installed}/flatland_plugins/flatland_plugins.xml",
        f"my_plugins {workspace / FOLDERS[space]}/my_plugins/flatland_plugins.xml",
    ]
    assert all(Path(line.partition(" ")[2]).is_file() for line in plugins)
    assert server == f"{installed}/flatland_server"


@pytest.mark.parametrize("space", ["devel", "install"])
def test_a_copied_package_overlays_the_installed_original(workspace, shell, space):
    found = shell.run(f"source '{workspace}/{space}/setup.bash'", f"python3 -c '{WHERE_FOUND}'")

    (renamed, renamed_file), (same, same_file) = (line.split() for line in found.splitlines())
    assert (renamed, same) == ("my_plugins.simple", "flatland_example_plugins.simple")
    assert all(file.startswith(f"{workspace}/") for file in (renamed_file, same_file))


def test_the_example_packages_tests_pass(workspace, shell):
    output = shell.run(
        f"source '{workspace}/devel/setup.bash'",
        # Without the same settings, it would configure the workspace again.
        f"catkin_make -C '{workspace}' {CONFIGURE} run_tests_my_plugins",
        f"catkin_test_results '{workspace}/build/test_results'",
    )

    assert "0 errors, 0 failures" in output


@pytest.mark.parametrize("space", ["devel", "install"])
def test_the_installed_server_runs_its_world(workspace, master, tmp_path, space):
    shell = Shell(tmp_path, master.uri)
    setup = f"source '{workspace}/{space}/setup.bash'"
    log = tmp_path / "launch.log"
    launch = f"roslaunch {LAUNCH_FILES[space]} show_viz:=false update_rate:=2000"

    with log.open("w") as output:
        server = shell.start(setup, f"exec {launch}", output=output)

    def is_running():
        assert server.poll() is None
        return "running" in log.read_text()

    try:
        wait_until(is_running, "the server to run")
        node = master.ask("lookupNode", "/flatland_server")
        for topic in ("/gate/contacts", "/box/count"):
            with tcpros_client.subscribe(node, topic, Int32) as counts:
                wait_until(lambda c=counts: next_message(c, Int32).data >= 3, f"3 on {topic}")
    finally:
        os.killpg(server.pid, signal.SIGTERM)
        server.wait(LIMIT)
        print(log.read_text())

    assert "Hello world" in log.read_text()
    assert (
        f"{workspace / FOLDERS[space]}/my_plugins/worlds/conveyor/world.yaml: 1 layer"
        in log.read_text()
    )
