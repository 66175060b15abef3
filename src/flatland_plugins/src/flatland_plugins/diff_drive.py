"""DiffDrive: a body that drives forwards and turns, as geometry_msgs/Twist commands."""

from typing import Any

from flatland_plugins.twist_drive import TwistDrive, read_dynamics, velocity_limits
from flatland_server import CoreDrive, ModelBody, YamlReader


class DiffDrive(TwistDrive):
    """Two wheels on an axle, or anything else that cannot move sideways."""

    def add_drive(self, config: YamlReader, body: ModelBody) -> CoreDrive:
        limits = read_dynamics(config)
        config.finish()
        self._drive = body.physics_body.add_drive(*limits)
        return CoreDrive(self._drive, (0, 2), velocity_limits(limits))

    def on_twist(self, twist: Any) -> None:
        self.command(twist.linear.x, twist.angular.z)

    def command(self, speed: float, yaw_rate: float) -> None:
        """Drives forwards [m/s] and turns [rad/s]."""
        self._drive.command(speed, 0.0, yaw_rate)
