"""A picture of the view, and its file."""

from python_qt_binding.QtGui import QPixmap
from python_qt_binding.QtWidgets import QWidget


def picture_of(panel: QWidget) -> QPixmap:
    """A picture of a widget as on the screen, including OpenGL content."""
    return panel.screen().grabWindow(panel.winId())


def write_picture(picture: QPixmap, file: str) -> bool:
    """Writes a picture in the format that the file's name ends with, or as PNG if that is none.

    Returns:
        Whether it could be written.
    """
    return bool(picture.save(file) or picture.save(file, "PNG"))
