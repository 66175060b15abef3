"""Logging of Python and ROS: records go to rosout, those of loading to a topic of the window.

Records that cannot be written are dropped.
"""

import contextlib
import logging
import sys
from typing import Iterator

import rospy
from std_msgs.msg import UInt8

from flatland_server.simulation import load_progress

_OTHERS = ("ros", "tf2_ros", "PIL")
"""Prefixes of loggers that ROS handles itself, or that do not concern users."""


class RosLogHandler(logging.Handler):
    """Forwards log records of ROS-free modules and plugins to rosout."""

    def emit(self, record: logging.LogRecord) -> None:
        if record.name.startswith(_OTHERS) or record.levelno < logging.INFO:
            return
        log = {"WARNING": rospy.logwarn, "ERROR": rospy.logerr, "CRITICAL": rospy.logfatal}
        log.get(record.levelname, rospy.loginfo)("%s", self.format(record))


class LoadingPublisher(logging.Handler):
    """Publishes the progress of loading a large world, for the window: `~loading`, in percent."""

    def __init__(self) -> None:
        super().__init__()
        self._publisher = rospy.Publisher("~loading", UInt8, queue_size=1, latch=True)
        load_progress.logger.addHandler(self)

    def emit(self, record: logging.LogRecord) -> None:
        percent = getattr(record, "percent", None)
        if percent is not None:
            self._publisher.publish(percent)


def tolerate_write_errors() -> None:
    """Makes the present log handlers report a write error once, and then drop records.

    A disk may be full, and a pipe closed. Python's handlers then print a traceback for each record,
    and ROS's raise the error in the code that logs.
    """
    for handler in _handlers():
        _Tolerance(handler)


def _handlers() -> Iterator[logging.Handler]:
    manager = logging.Logger.manager
    loggers = [manager.root, *manager.loggerDict.values()]
    unique = {
        id(handler): handler
        for logger in loggers
        if isinstance(logger, logging.Logger)
        for handler in logger.handlers
    }
    return iter(unique.values())


class _Tolerance:
    """Replaces a handler's `emit` and `handleError`."""

    def __init__(self, handler: logging.Handler) -> None:
        self._name = getattr(handler, "baseFilename", "the terminal")
        self._emit = handler.emit
        self._handle_error = handler.handleError
        self._has_failed = False
        handler.emit = self.emit  # type: ignore[method-assign]
        handler.handleError = self.handle_error  # type: ignore[method-assign]

    def emit(self, record: logging.LogRecord) -> None:
        try:
            self._emit(record)
        except OSError as error:
            self._report(error)

    def handle_error(self, record: logging.LogRecord) -> None:
        error = sys.exc_info()[1]
        if isinstance(error, OSError):
            self._report(error)
        else:
            self._handle_error(record)

    def _report(self, error: OSError) -> None:
        if self._has_failed:
            return
        self._has_failed = True
        with contextlib.suppress(OSError):
            sys.stderr.write(f"log messages are lost, {self._name} cannot be written: {error}\n")
