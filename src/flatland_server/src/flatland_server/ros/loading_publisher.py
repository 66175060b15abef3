"""Publishes the progress of loading a large world, for the window: `~loading`, in percent."""

import logging

import rospy
from std_msgs.msg import UInt8

from flatland_server.simulation import load_progress


class LoadingPublisher(logging.Handler):
    """Publishes the percents of `load_progress`; nothing for a world that is loaded quickly."""

    def __init__(self) -> None:
        super().__init__()
        self._publisher = rospy.Publisher("~loading", UInt8, queue_size=1, latch=True)
        load_progress.logger.addHandler(self)

    def emit(self, record: logging.LogRecord) -> None:
        percent = getattr(record, "percent", None)
        if percent is not None:
            self._publisher.publish(percent)
