"""A virtual screen with a window manager: windows have title bars, and must fit below them."""

import os
import shutil
import subprocess
from contextlib import contextmanager

import pytest
from x_server import x_server


@contextmanager
def desktop(width, height):
    """An X server with openbox, while the context lasts.

    Args:
        width: the screen's width [pixels].
        height: the screen's height [pixels].

    Yields:
        The name of the display.
    """
    if not shutil.which("openbox"):
        pytest.skip("openbox is not installed")
    with x_server(width, height) as display:
        manager = subprocess.Popen(
            ["openbox", "--sm-disable"],
            env={**os.environ, "DISPLAY": display},
            stderr=subprocess.DEVNULL,
        )
        try:
            yield display
        finally:
            manager.terminate()
            manager.wait(10)
