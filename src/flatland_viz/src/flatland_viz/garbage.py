"""Garbage collection, where Qt is used."""

import gc

from python_qt_binding.QtCore import QTimer

_PERIOD = 200  # ms


def collect_on_this_thread() -> QTimer:
    """Lets Python collect garbage on this thread alone from now on, between events of Qt.

    On one of rospy's threads, or while Qt goes through its list of all widgets, Python would delete
    widgets that Qt uses, and Qt would crash.

    Returns:
        What collects, until it is stopped.
    """
    gc.disable()
    timer = QTimer()
    timer.timeout.connect(_collect)
    timer.start(_PERIOD)
    return timer


def _collect() -> None:
    """Collects the oldest generation that is due, as Python itself does it."""
    for generation in (2, 1, 0):
        if gc.get_count()[generation] > gc.get_threshold()[generation] > 0:
            gc.collect(generation)
            return
