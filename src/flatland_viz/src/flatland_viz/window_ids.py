"""Prevents a crash of rviz when its render window is created.

Three connections to the X server take part, and the server may answer one before it has read what
was sent earlier on another:

1. Qt creates the window of rviz's RenderWidget, which asks for its id (`winId()`) and at once has
   Ogre create a child of it. (rviz 1.14.19 no longer calls `QApplication::sync()` in between.)
2. Ogre creates that child on a connection of its own, and flushes it, but does not wait.
3. Mesa asks for the size of that child on the connection that belongs to the OpenGL context.

If the window does not exist yet in step 2 or 3, `XGetGeometry` fails. Mesa 22.3's
`swrastGetDrawableInfo` ignores that, and uses a size that was never set: such as 168 x 0. The first
frame is then drawn beyond the buffer (`free(): invalid next size`, or SIGSEGV at any later time).

So the first two connections are made to wait for the server's answer.
"""

import ctypes
from contextlib import contextmanager
from typing import Iterator

from python_qt_binding.QtCore import QEvent, QObject
from python_qt_binding.QtGui import QCursor
from python_qt_binding.QtWidgets import QApplication


class _QtSynchroniser(QObject):
    """Waits for the X server after each creation of a widget's window."""

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        if event.type() == QEvent.WinIdChange:
            QCursor.pos()  # needs the X server's answer, hence waits for all requests before
        return False


@contextmanager
def synchronised_window_ids() -> Iterator[None]:
    """A context in which a window exists in the X server once its id is known.

    Connections that Xlib opens in it stay synchronous for good, as after `XSynchronize`: each
    request waits until it was processed. With OpenGL that is one round trip per frame.
    """
    synchroniser = _QtSynchroniser()
    application = QApplication.instance()
    application.installEventFilter(synchroniser)
    # XOpenDisplay calls XSynchronize with this variable (manual page XSynchronize(3), "_Xdebug").
    synchronous = ctypes.c_int.in_dll(ctypes.CDLL("libX11.so.6"), "_Xdebug")
    before, synchronous.value = synchronous.value, 1
    try:
        yield
    finally:
        synchronous.value = before
        application.removeEventFilter(synchroniser)
