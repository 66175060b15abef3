"""The libraries with which SDL, hence pygame, opens an X display.

SDL loads them when it opens a display, and says nothing if one of them is missing.
"""

import ctypes
from contextlib import suppress

_PACKAGES = {"libX11.so.6": "libx11-6", "libXext.so.6": "libxext6"}
"""Debian's packages with them."""


def missing_libraries() -> str:
    """What is missing, and the command that installs it on Debian; empty if nothing is."""
    missing = dict(_PACKAGES)
    for library in _PACKAGES:
        with suppress(OSError):
            ctypes.CDLL(library)
            del missing[library]
    if not missing:
        return ""
    verb = "is" if len(missing) == 1 else "are"
    return f"{' and '.join(missing)} {verb} missing: apt install {' '.join(missing.values())}"
