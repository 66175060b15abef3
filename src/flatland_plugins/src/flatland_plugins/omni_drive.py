"""OmniDrive: a body that moves in any direction and turns, as geometry_msgs/Twist commands."""

from typing import Any

from flatland_plugins.twist_drive import VelocityDrive


class OmniDrive(VelocityDrive):
    """Mecanum or swerve wheels: x is forwards and y to the left (REP 103).

    The keys are those of DiffDrive. `linear_dynamics` limits the velocity in the plane, not each of
    its components.
    """

    columns = (0, 1, 2)

    def on_twist(self, twist: Any) -> None:
        self.command(twist.linear.x, twist.linear.y, twist.angular.z)

    def command(self, vx: float, vy: float, yaw_rate: float) -> None:
        """Moves forwards and to the left [m/s, m/s], and turns [rad/s]."""
        self._drive.command(vx, vy, yaw_rate)

    def describe(self, command: Any) -> str:
        linear = command.linear
        return f"linear.x={linear.x} linear.y={linear.y} angular.z={command.angular.z}"
