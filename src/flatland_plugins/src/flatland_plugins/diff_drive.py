"""DiffDrive: a body that drives forwards and turns, as geometry_msgs/Twist commands."""

from typing import Any

from flatland_plugins.twist_drive import VelocityDrive


class DiffDrive(VelocityDrive):
    """Two wheels on an axle, or anything else that cannot move sideways."""

    columns = (0, 2)

    def on_twist(self, twist: Any) -> None:
        self.command(twist.linear.x, twist.angular.z)

    def command(self, speed: float, yaw_rate: float) -> None:
        """Drives forwards [m/s] and turns [rad/s]."""
        self._drive.command(speed, 0.0, yaw_rate)
