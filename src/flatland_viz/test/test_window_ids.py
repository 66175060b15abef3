"""The remedy for rviz's crash at the creation of its render window, and its test program."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from plain_rviz import steady_windows

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

STEADY_WINDOWS = """
from ctypes import *

x11 = CDLL(None)
x11.XOpenDisplay.restype = c_void_p
x11.XDefaultRootWindow.restype = x11.XCreateSimpleWindow.restype = c_ulong
x11.XCreateWindow.restype = c_ulong
errors = []
note = CFUNCTYPE(c_int, c_void_p, c_void_p)(lambda *_: errors.append("X error") or 0)
x11.XSetErrorHandler(note)

def size_of(window):
    width, height, other = c_uint(168), c_uint(0), [c_long() for _ in range(5)]
    root, x, y, border, depth = map(byref, other)
    size = byref(width), byref(height)
    x11.XGetGeometry(of_ogre, window, root, x, y, *size, border, depth)
    return width.value, height.value

of_qt, of_ogre = c_void_p(x11.XOpenDisplay(None)), c_void_p(x11.XOpenDisplay(None))
desktop = c_ulong(x11.XDefaultRootWindow(of_qt))
parent = c_ulong(x11.XCreateSimpleWindow(of_qt, desktop, 0, 0, 200, 100, 0, 0, 0))  # not sent yet
window = c_ulong(
    x11.XCreateWindow(of_ogre, parent, 0, 0, 100, 30, 0, 0, 0, None, c_ulong(0), None)
)
print(size_of(window), errors)
x11.XDestroyWindow(of_ogre, window)
print(size_of(window), errors)
"""
"""The windows of Qt and Ogre as plain rviz creates them, and Mesa's question for their size."""


def output_of(program, display, **variables):
    run = subprocess.run(
        [sys.executable, "-c", program],
        env={**os.environ, "DISPLAY": display, **variables},
        stdout=subprocess.PIPE,
        text=True,
        check=True,
        timeout=60,
    )
    return run.stdout


def test_connections_opened_meanwhile_are_synchronous(display):
    assert output_of(PROGRAM, display).split() == ["False", "True", "False"]


def test_windows_of_plain_rviz_have_a_size(display, tmp_path):
    libraries = f"{steady_windows(tmp_path)} libX11.so.6"
    output = output_of(STEADY_WINDOWS, display, LD_PRELOAD=libraries)
    assert output.splitlines() == ["(100, 30) []", "(1, 1) ['X error']"]


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
