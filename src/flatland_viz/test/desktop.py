"""A virtual screen with a window manager: windows have title bars, and must fit below them."""

import os
import shutil
import subprocess
from contextlib import contextmanager

import pytest


@contextmanager
def desktop(size):
    """An X server with openbox, while the context lasts.

    Args:
        size: of the screen in pixels, such as "1280x800".

    Yields:
        The name of the display.
    """
    for program in ("Xvfb", "openbox"):
        if not shutil.which(program):
            pytest.skip(f"{program} is not installed")
    read, write = os.pipe()
    server = subprocess.Popen(
        ["Xvfb", "-displayfd", str(write), "-screen", "0", f"{size}x24", "-noreset"],
        pass_fds=[write],
        stderr=subprocess.DEVNULL,
    )
    os.close(write)
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
