"""Warnings of transforms, which come hundreds of times a second."""

import subprocess
import sys

import pytest

from flatland_viz.transform_warnings import TransformWarnings

BOTH_THREADS_WARN = """
import ctypes, fcntl, os, sys, threading

import rospy
import tf2_py
from geometry_msgs.msg import TransformStamped

from flatland_viz.transform_warnings import print_warnings_once, take_warnings

print_warnings_once()
log = ctypes.CDLL("libconsole_bridge.so.1.0")._ZN14console_bridge3logEPKciNS_8LogLevelES1_z
thread = threading.Thread(target=log, args=(b"file", 1, 2, b"a thread without the GIL at time 1"))
transforms = tf2_py.BufferCore()
transform = TransformStamped(child_frame_id="base")
transform.header.frame_id = "map"
transform.header.stamp = rospy.Time(1)
transform.transform.rotation.w = 1.0
transforms.set_transform(transform, "robot")

# The pipe is full: the thread stops while it prints, with the lock of console_bridge and without
# the GIL. This thread has the GIL for good, also while it makes room.
output, errors = os.pipe()
fcntl.fcntl(errors, fcntl.F_SETFL, os.O_NONBLOCK)
size = fcntl.fcntl(errors, fcntl.F_GETPIPE_SZ)
os.write(errors, b"." * size)
fcntl.fcntl(errors, fcntl.F_SETFL, 0)
os.dup2(errors, 2)
sys.setswitchinterval(1000.0)
thread.start()
read, text = ctypes.PyDLL(None).read, ctypes.create_string_buffer(size)
while b"without the GIL" not in text.raw:
    read(output, text, size)

transforms.set_transform(transform, "robot")
thread.join()
print(list(take_warnings().items()))
"""

MANY_WARNINGS = """
import ctypes
from flatland_viz.transform_warnings import print_warnings_once, take_warnings

print_warnings_once()
log = ctypes.CDLL("libconsole_bridge.so.1.0")._ZN14console_bridge3logEPKciNS_8LogLevelES1_z
for number in range(10_000):
    log(b"file", 1, 2, b"frame %d%s", number, b"x" * 100_000 if number == 0 else b"")
taken = take_warnings()
print(len(taken), sum(taken.values()), max(map(len, taken)), take_warnings())
"""


def output_of(program):
    """The output of a program, and the lines of its log."""
    command = [sys.executable, "-c", program]
    run = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert run.returncode == 0, run.stderr
    return run.stdout, run.stderr.splitlines()


@pytest.mark.slow
def test_warnings_with_and_without_the_gil_do_not_deadlock():
    output, _ = output_of(BOTH_THREADS_WARN)
    repeated = "TF_REPEATED_DATA ignoring data with redundant timestamp for frame base"
    assert output == f"{[('a thread without the GIL', 1), (repeated, 1)]}\n"


def test_texts_that_are_counted_are_limited_in_number_and_length():
    output, log = output_of(MANY_WARNINGS)
    assert output == "101 10000 500 {}\n"
    assert len(log) == 101


def test_a_warning_that_goes_on_is_reported_with_its_number():
    warnings = TransformWarnings()
    reports = [warnings.update({"odom": 19, "base": 1}, 100.0)]
    for second in range(1, 4):
        reports.append(warnings.update({"odom": 100}, 100.0 + second))
    assert reports == [{}, {"odom": 119}, {"odom": 219}, {"odom": 319}]


def test_a_warning_that_comes_no_more_has_ended():
    warnings = TransformWarnings()
    warnings.update({"old": 30}, 100.0)
    assert warnings.update({"new": 30}, 109.0) == {"old": 30, "new": 30}
    assert warnings.update({}, 111.0) == {"new": 30}
    assert warnings.update({"old": 1}, 112.0) == {"new": 30}
