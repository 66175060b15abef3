"""The libraries with which SDL, hence pygame, opens an X display.

SDL loads them when it opens a display, and says nothing if one of them is missing.
"""

import ctypes
from contextlib import suppress

_PACKAGES = {"libX11.so.6": "libx11-6", "libXext.so.6": "libxext6"}
"""The Debian package of each library."""


def missing_libraries() -> str:
    """The missing libraries, and the command to install them on Debian; empty if there are none."""
    missing = dict(_PACKAGES)
    for library in _PACKAGES:
        with suppress(OSError):
            ctypes.CDLL(library)
            del missing[library]
    if not missing:
        return ""
    verb = "is" if len(missing) == 1 else "are"
    return f"{' and '.join(missing)} {verb} missing: apt install {' '.join(missing.values())}"
