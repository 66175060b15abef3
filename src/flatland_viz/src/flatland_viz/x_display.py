"""The X server on which rviz draws. A desktop of Wayland has one, too: XWayland."""

import ctypes
import os
import time

_PLATFORM = "QT_QPA_PLATFORM"


def choose_x() -> str:
    """Makes Qt draw by X, also on a desktop of Wayland. To be called before Qt starts.

    Returns:
        What is missing for a window; empty if nothing is.
    """
    platform = os.environ.get(_PLATFORM, "")
    if not _answers():
        has_wayland = "WAYLAND_DISPLAY" in os.environ
        return "no X display, which rviz needs (XWayland)" if has_wayland else "no display"
    if not platform or platform.startswith("wayland"):
        os.environ[_PLATFORM] = "xcb"
    elif not platform.startswith("xcb"):
        return f"{_PLATFORM} is {platform!r}, and rviz needs 'xcb'"
    return ""


def _answers() -> bool:
    """True if the X server named by DISPLAY accepts connections.

    A server such as Xvfb resets when its last client disconnects, and refuses connections
    meanwhile: so this tries for a second, and keeps its connection open until Qt has one.
    """
    try:
        x11 = ctypes.CDLL("libX11.so.6")
    except OSError:
        return False
    x11.XOpenDisplay.restype = ctypes.c_void_p
    for _ in range(10 if os.environ.get("DISPLAY") else 0):
        if x11.XOpenDisplay(None):
            return True
        time.sleep(0.1)
    return False
