"""Makes a crash of rviz less likely when its render window is created.

rviz's RenderWidget gets a window id from Qt and at once has Ogre create a window with it, on
another connection to the X server. The server may not have processed Qt's request to create that
window by then: rviz 1.14.19 no longer synchronises the two. Mesa 22.3 ignores that `XGetGeometry`
then fails in `swrastGetDrawableInfo`, and uses a size that was never set: the first frame is drawn
beyond the buffer (`free(): invalid next size`, or SIGSEGV).
"""

from contextlib import contextmanager
from typing import Iterator

from python_qt_binding.QtCore import QEvent, QObject
from python_qt_binding.QtGui import QCursor
from python_qt_binding.QtWidgets import QApplication


class _Synchroniser(QObject):
    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        if event.type() == QEvent.WinIdChange:
            QCursor.pos()  # waits for the X server's answer, hence for all requests before
        return False


@contextmanager
def synchronised_window_ids() -> Iterator[None]:
    """A context in which a widget's window exists in the X server once its id is known."""
    application = QApplication.instance()
    synchroniser = _Synchroniser()
    application.installEventFilter(synchroniser)
    try:
        yield
    finally:
        application.removeEventFilter(synchroniser)
