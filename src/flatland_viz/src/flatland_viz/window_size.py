"""The size of windows that fit on the screen."""

from python_qt_binding.QtCore import QSize
from python_qt_binding.QtWidgets import QApplication

_FRAME = QSize(16, 48)
"""Of a window manager: its borders and title bar, unknown before the window is shown."""


def on_screen(width: int, height: int) -> QSize:
    """This size, or less if the screen without panels is smaller; without a window's frame.

    In device-independent pixels.
    """
    available = QApplication.primaryScreen().availableSize()
    return QSize(width, height).boundedTo(available - _FRAME)
