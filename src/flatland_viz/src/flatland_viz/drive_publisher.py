"""Publishes the commands of the Drive panel."""

from typing import Optional

import rospy
from geometry_msgs.msg import Twist
from python_qt_binding.QtCore import QObject, QTimer

from flatland_teleop.command_publisher import command_publisher
from flatland_teleop.driving_keys import Command

_PERIOD = 66  # ms: 15 Hz


class DrivePublisher(QObject):
    """Repeats a command until it is zero; zero is published once.

    A drive keeps its last command, so a zero always follows the other commands.
    """

    def __init__(self) -> None:
        super().__init__()
        self._publisher: Optional[rospy.Publisher] = None
        self._topic = ""
        self.velocity = Command()
        """The present command."""
        self._timer = QTimer(self, interval=_PERIOD)
        self._timer.timeout.connect(self._publish)

    def open(self, topic: str) -> None:
        """Stops the former robot, and publishes on this topic; on none if it is empty."""
        if topic == self._topic:
            return
        self.command(Command())
        if self._publisher is not None:
            self._publisher.unregister()
        self._topic = topic
        self._publisher = command_publisher(topic) if topic else None

    def command(self, velocity: Command) -> None:
        """Commands a velocity."""
        if self._publisher is None or velocity == self.velocity:
            return
        self.velocity = velocity
        self._publish()
        if velocity == Command():
            self._timer.stop()
        elif not self._timer.isActive():
            self._timer.start()

    def _publish(self) -> None:
        message = Twist()
        message.linear.x, message.linear.y, message.angular.z = self.velocity
        if self._publisher is not None and not rospy.is_shutdown():
            self._publisher.publish(message)
