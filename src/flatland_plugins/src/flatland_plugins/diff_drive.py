"""DiffDrive: a body that goes forwards and turns, as geometry_msgs/Twist commands it."""

import logging
import math

from geometry_msgs.msg import Twist

from flatland_plugins.dynamics_limits import DynamicsLimits
from flatland_plugins.odometry import OdometryConfig, OdometryPublisher
from flatland_server.model_plugin import ModelPlugin
from flatland_server.timekeeper import Timekeeper
from flatland_server.update_timer import UpdateTimer
from flatland_server.yaml_reader import YamlReader

logger = logging.getLogger(__name__)


class DiffDrive(ModelPlugin):
    """Moves a body at the last commanded velocity of its origin, within its dynamics limits."""

    def on_initialize(self, config: YamlReader) -> None:
        """Reads the documented keys and opens the topics."""
        body = self.get_body(config)
        twist_sub = config.get_string("twist_sub", "cmd_vel")
        pub_rate = config.get_rate("pub_rate", math.inf)
        linear = DynamicsLimits.read(config, "linear_dynamics")
        angular = DynamicsLimits.read(config, "angular_dynamics")
        odometry = OdometryConfig.read(config)
        config.finish()

        self._topic = self.node.resolve(twist_sub)
        self._drive = body.physics_body.add_drive(linear, angular)
        self._odometry = OdometryPublisher(self, body, odometry)
        self.update_timer = UpdateTimer(pub_rate)
        self.node.subscribe(twist_sub, Twist, self._on_twist)

    def _on_twist(self, twist: Twist) -> None:
        try:
            self._drive.command(twist.linear.x, 0.0, twist.angular.z)
        except ValueError as error:
            logger.warning(
                "%s: %s; ignored linear.x=%s angular.z=%s",
                *(self._topic, error, twist.linear.x, twist.angular.z),
            )

    def before_physics_step(self, timekeeper: Timekeeper) -> None:
        """Publishes odometry; the core drives."""
        self._odometry.publish(timekeeper.nanoseconds)
