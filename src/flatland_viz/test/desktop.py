"""A virtual screen with a window manager: windows have title bars, and must fit below them."""

import os
import shutil
import subprocess
from contextlib import contextmanager, suppress

import pytest


@contextmanager
def desktop(width, height):
    """An X server with openbox, while the context lasts.

    Args:
        width: of the screen [pixels].
        height: of the screen [pixels].

    Yields:
        The name of the display.
    """
    for program in ("Xvfb", "openbox"):
        if not shutil.which(program):
            pytest.skip(f"{program} is not installed")
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
    with os.fdopen(read) as pipe:
        display = f":{pipe.readline().strip()}"
    manager = subprocess.Popen(
        ["openbox", "--sm-disable"],
        env={**os.environ, "DISPLAY": display},
        stderr=subprocess.DEVNULL,
    )
    try:
        yield display
    finally:
        for program in (manager, server):
            program.terminate()
            program.wait(10)
