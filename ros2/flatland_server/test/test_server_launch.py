"""The launch file, as `colcon test` runs it: topics, a service, and the end."""

import time
import unittest
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
import rclpy
from ament_index_python.packages import get_package_share_directory
from flatland_msgs.srv import SpawnModel
from launch import LaunchDescription
from launch.actions import IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch_testing import post_shutdown_test
from launch_testing.actions import ReadyToTest
from launch_testing.asserts import assertExitCodes
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import LaserScan

LAUNCH_FILE = Path(get_package_share_directory("flatland_server"), "launch", "server.launch.py")
LIMIT = 60.0
"""Real time after which a test fails [s]."""
BOX = "bodies: [{name: box, footprints: [{type: circle, radius: 0.2, density: 1}]}]"


@pytest.mark.launch_test
def generate_test_description():
    server = IncludeLaunchDescription(
        PythonLaunchDescriptionSource(str(LAUNCH_FILE)),
        launch_arguments={"world_path": "office", "show_viz": "false"}.items(),
    )
    return LaunchDescription([server, ReadyToTest()])


class TestServer(unittest.TestCase):
    def setUp(self):
        rclpy.init()
        self.node = rclpy.create_node("test")

    def tearDown(self):
        self.node.destroy_node()
        rclpy.shutdown()

    def wait_until(self, is_true, what):
        ends = time.monotonic() + LIMIT
        while not is_true():
            self.assertLess(time.monotonic(), ends, f"{what} did not come")
            rclpy.spin_once(self.node, timeout_sec=0.1)

    def test_time_and_scans_are_published(self):
        for kind, topic in ((Clock, "/clock"), (LaserScan, "/scan")):
            messages = []
            self.node.create_subscription(kind, topic, messages.append, 10)
            self.wait_until(lambda messages=messages: messages, topic)

    def test_a_model_is_spawned(self):
        client = self.node.create_client(SpawnModel, "/spawn_model")
        self.wait_until(client.service_is_ready, "/spawn_model")
        with TemporaryDirectory() as folder:
            file = Path(folder, "box.model.yaml")
            file.write_text(BOX)
            future = client.call_async(SpawnModel.Request(yaml_path=str(file), name="box"))
            self.wait_until(future.done, "a response")
        self.assertTrue(future.result().success, future.result().message)


@post_shutdown_test()
class TestEnd(unittest.TestCase):
    def test_sigint_ends_it_without_an_error(self, proc_info):
        assertExitCodes(proc_info)
