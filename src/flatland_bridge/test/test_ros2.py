"""ROS 2 by rclpy: a distribution of it, with a program of plain rclpy in a process of its own.

ROS2_DISTRIBUTIONS="jazzy kilted" tests both.
"""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from ros2_environment import FOLDER, Ros2Environment

pytestmark = pytest.mark.slow

CHECKS = Path(__file__).with_name("rclpy_checks.py")
DISTRIBUTIONS = os.environ.get("ROS2_DISTRIBUTIONS", "jazzy").split()
"""Each takes four minutes when it is installed first."""


@pytest.mark.skipif(sys.version_info[:2] != (3, 11), reason="the wheels are for Python 3.11")
@pytest.mark.skipif(
    re.fullmatch(r"[\w/.+-]+", str(FOLDER), re.ASCII) is None,
    reason="rosidl's CMake takes no path with spaces or other letters than ASCII's",
)
@pytest.mark.parametrize("distribution", DISTRIBUTIONS)
def test_nodes_of_ros_2(distribution, tmp_path):
    environment = Ros2Environment(distribution)
    variables = {**environment.environment(), "ROS_LOG_DIR": str(tmp_path)}
    result = subprocess.run(
        [
            *(str(environment.python), str(CHECKS), "-q", "-p", "no:cacheprovider"),
            *("--noconftest", "-c", os.devnull, "--rootdir", str(CHECKS.parent)),
            *("--basetemp", str(tmp_path / "base")),
        ],
        env={**variables, "ROS_DOMAIN_ID": str(1 + os.getpid() % 100)},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=900,
    )

    assert result.returncode == 0, result.stdout[-8000:]
