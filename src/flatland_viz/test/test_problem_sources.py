"""Warnings of tf2 on their way into the window's list of problems."""

import os
import subprocess
import sys
from ast import literal_eval

import pytest

pytestmark = pytest.mark.slow

PROGRAM = """
import rospy
import tf2_py
from geometry_msgs.msg import TransformStamped
from python_qt_binding.QtCore import QCoreApplication

from flatland_viz.problem_sources import ProblemSources

rospy.init_node("window")
application = QCoreApplication([])
sources = ProblemSources()
def note(group, problems):
    for problem in problems:
        print(tuple(problem))
        application.quit()

sources.reported.connect(note)
sources.start()
transform = TransformStamped(child_frame_id="base")
transform.header.frame_id = "map"
transform.header.stamp = rospy.Time(1)
transform.transform.rotation.w = 1.0
transforms = tf2_py.BufferCore()
for _ in range(31):
    transforms.set_transform(transform, "two robots")
application.exec_()
"""


def test_a_transform_that_is_sent_again_and_again_is_a_problem(master):
    run = subprocess.run(
        [sys.executable, "-c", PROGRAM],
        env={**os.environ, "ROS_MASTER_URI": master.uri},
        stdout=subprocess.PIPE,
        text=True,
        check=True,
        timeout=60,
    )
    text = "TF_REPEATED_DATA ignoring data with redundant timestamp for frame base"
    source, what, is_error, times, _ = literal_eval(run.stdout)
    assert (source, what, is_error, times) == ("transforms", text, False, 30)
