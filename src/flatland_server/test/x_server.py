"""A virtual screen."""

import os
import shutil
import subprocess
from contextlib import contextmanager

import pytest


@contextmanager
def x_server(width, height):
    """An X server, while the context lasts.

    Args:
        width: the screen's width [pixels].
        height: the screen's height [pixels].

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
    try:
        with os.fdopen(read) as pipe:
            yield f":{pipe.readline().strip()}"
    finally:
        server.terminate()
        server.wait(10)
