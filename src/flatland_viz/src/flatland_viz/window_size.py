"""The size of the window when it opens for the first time."""

from python_qt_binding.QtCore import QSize

_WANTED = QSize(1280, 800)
_FRAME = QSize(16, 48)
"""Of a window manager: its borders and title bar, unknown before the window is shown."""


def first_size(available: QSize) -> QSize:
    """The size of the window, without its frame.

    Args:
        available: the screen without panels, in device-independent pixels.
    """
    return _WANTED.boundedTo(available - _FRAME)
