"""Forwards Python's logging to rosout."""

import logging

import rospy

_OTHERS = ("ros", "tf2_ros", "PIL")
"""Prefixes of loggers whose records ROS handles itself, or that do not concern users."""


class RosLogHandler(logging.Handler):
    """Forwards what ROS-free modules and plugins log to rosout."""

    def emit(self, record: logging.LogRecord) -> None:
        if record.name.startswith(_OTHERS) or record.levelno < logging.INFO:
            return
        log = {"WARNING": rospy.logwarn, "ERROR": rospy.logerr, "CRITICAL": rospy.logfatal}
        log.get(record.levelname, rospy.loginfo)("%s", self.format(record))
