"""The remedy for rviz's crash at the creation of its render window, and its test program."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

PROGRAM = """
import ctypes
from python_qt_binding.QtWidgets import QApplication, QWidget
from flatland_viz.window_ids import synchronised_window_ids

x11 = ctypes.CDLL("libX11.so.6")
x11.XOpenDisplay.restype = ctypes.c_void_p
x11.XSynchronize.argtypes = [ctypes.c_void_p, ctypes.c_int]
x11.XSynchronize.restype = ctypes.c_void_p  # what was called after each request so far

def is_synchronous():
    return x11.XSynchronize(x11.XOpenDisplay(None), 1) is not None

application = QApplication(["test"])
print(is_synchronous())
with synchronised_window_ids():
    print(is_synchronous())
print(is_synchronous())
"""


def test_connections_opened_meanwhile_are_synchronous(display):
    run = subprocess.run(
        [sys.executable, "-c", PROGRAM],
        env={**os.environ, "DISPLAY": display},
        stdout=subprocess.PIPE,
        text=True,
        check=True,
        timeout=60,
    )
    assert run.stdout.split() == ["False", "True", "False"]


def test_a_window_starts_and_ends(display, tmp_path):
    program = Path(__file__).with_name("window_starts.py")
    run = subprocess.run(
        [sys.executable, program, "--starts", "1", "--seconds", "0.2"],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        text=True,
        timeout=150,
    )
    assert run.returncode == 0, run.stdout
    assert "1 ended as asked" in run.stdout
