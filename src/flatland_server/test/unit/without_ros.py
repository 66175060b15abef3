"""Programs run in a Python in which there is no ROS."""

import os
import sys

from commands import run

BLOCK_ROS = """
import sys

class Blocker:
    def find_spec(self, name, path=None, target=None):
        package = name.partition(".")[0]
        if package.endswith("_msgs") or package in BLOCKED:
            raise ModuleNotFoundError(f"{name} is blocked", name=name)

BLOCKED = (
    "actionlib", "genmsg", "genpy", "rosgraph", "roslaunch", "roslib", "rospkg", "rospy",
    "std_srvs", "tf2_ros",
)
sys.meta_path.insert(0, Blocker())
"""


def run_without_ros(program: str, *arguments: object) -> str:
    """The output of a program in a Python in which no package of ROS can be imported."""
    return run_program(BLOCK_ROS + program, *arguments)


def run_program(program: str, *arguments: object) -> str:
    """The output of a program in a Python of its own."""
    paths = [os.environ.get("PYTHONPATH", ""), *sys.path]  # the workspace's, then the tests' own
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, paths))}
    return run(sys.executable, "-c", program, *arguments, env=environment)
