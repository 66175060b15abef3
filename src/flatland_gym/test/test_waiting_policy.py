"""The node of a policy says which of its topics brings no message."""

import os
import subprocess

import pytest
from ros_processes import executable
from waiting import wait_until

pytestmark = pytest.mark.slow


@pytest.fixture
def start_policy(master, tmp_path):
    """Starts the node with remappings; returns a function that returns its output so far."""
    processes = []

    def start(*remappings):
        log = tmp_path / f"{len(processes)}.log"
        with log.open("w") as file:
            processes.append(
                subprocess.Popen(
                    [executable("flatland_gym", "drive_policy"), *remappings],
                    env={**os.environ, "ROS_MASTER_URI": master.uri, "PYTHONUNBUFFERED": "1"},
                    stdout=file,
                    stderr=subprocess.STDOUT,
                )
            )
        return log.read_text

    yield start
    for process in processes:
        process.terminate()
    for process in processes:
        process.wait(20)


def test_it_waits_for_topics_and_names_the_missing_one(start_server, start_policy):
    start_server()
    ready = start_policy("__name:=ready")
    waiting = start_policy("scan:=scan_front", "__name:=waiting")
    blind = start_policy("odometry/ground_truth:=odom", "__name:=blind")

    wait_until(lambda: "ready for goals" in ready(), "the node with all topics")
    text = (
        "waiting for sensor_msgs/LaserScan on /scan_front, which has no publisher (there is /scan)"
    )
    wait_until(lambda: text in waiting(), "the missing topic of scans")
    text = "waiting for nav_msgs/Odometry on /odom, which has no publisher (there is /odometry/"
    wait_until(lambda: text in blind(), "the missing topic of odometry")
    assert "ready" not in waiting() + blind()
    assert "LaserScan" not in blind()
    assert "Odometry" not in waiting()
