"""ROS 2 by rclpy: a distribution of it, with a program of plain rclpy in a process of its own.

ROS2_DISTRIBUTIONS="jazzy kilted" tests both.
"""

import os
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from commands import run
from ros2_environment import DISTRIBUTIONS, Ros2Environment
from soak.bridge_soak import BridgeSoak
from soak.findings import Findings

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.version_info[:2] != (3, 11), reason="the wheels are for Python 3.11"),
]

CHECKS = Path(__file__).with_name("rclpy_checks.py")


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Runs with all distributions at the same time: they mostly wait."""
    with ThreadPoolExecutor() as pool:
        yield {
            each: pool.submit(run_checks, each, domain, tmp_path_factory.mktemp(each))
            for domain, each in enumerate(DISTRIBUTIONS, 1 + os.getpid() % 100)
        }


def run_checks(distribution, domain, folder):
    environment = Ros2Environment(distribution)
    variables = {**environment.environment(), "ROS_LOG_DIR": str(folder)}
    run(
        *(environment.python, CHECKS, "-q", "-p", "no:cacheprovider", "--durations=10"),
        *("--noconftest", "-c", os.devnull, "--rootdir", CHECKS.parent),
        *("--basetemp", folder / "base"),
        env={**variables, "ROS_DOMAIN_ID": str(domain)},
    )


def test_a_misbehaving_node_disturbs_no_others(runs, tmp_path):
    findings = Findings()
    soak = BridgeSoak("ros2", tmp_path / "ros2", share=0.25)
    soak.run_round(1, ["ros2_node"], findings)
    soak.close()

    assert findings.violations == []


@pytest.mark.parametrize("distribution", DISTRIBUTIONS)
def test_nodes_of_ros_2(distribution, runs):
    runs[distribution].result()
