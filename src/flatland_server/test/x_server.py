"""A virtual screen."""

import os
import shutil
import subprocess
from contextlib import contextmanager, suppress

import pytest


@contextmanager
def x_server(width, height):
    """An X server, while the context lasts.

    Args:
        width: of the screen [pixels].
        height: of the screen [pixels].

    Yields:
        The name of the display.
    """
    if not shutil.which("Xvfb"):
        pytest.skip("Xvfb is not installed")
    read, write = os.pipe()
    screen = ("-screen", "0", f"{width}x{height}x24")
    server = subprocess.Popen(
        ["Xvfb", "-displayfd", str(write), *screen, "-nolisten", "tcp", "-noreset"],
        pass_fds=[write],
        stderr=subprocess.DEVNULL,
    )
    os.close(write)
    # rviz crashes if it asks for a window before the X server has made it (window_ids.py).
    # This is rarer if the server never waits for a core.
    with suppress(OSError):  # needs a privilege
        os.sched_setscheduler(server.pid, os.SCHED_RR, os.sched_param(1))
    try:
        with os.fdopen(read) as pipe:
            yield f":{pipe.readline().strip()}"
    finally:
        server.terminate()
        server.wait(10)
