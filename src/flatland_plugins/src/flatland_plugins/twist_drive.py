"""What drives have in common that geometry_msgs/Twist commands."""

import contextlib
import logging
import math
from abc import ABC, abstractmethod
from operator import attrgetter
from typing import Callable, ClassVar, Tuple

from geometry_msgs.msg import Twist

from flatland_plugins.dynamics_limits import DynamicsLimits
from flatland_plugins.odometry import OdometryConfig, OdometryPublisher
from flatland_server import GoneError, ModelBody, ModelPlugin, Timekeeper, UpdateTimer, YamlReader

logger = logging.getLogger(__name__)


class TwistDrive(ModelPlugin, ABC):
    """Base of a drive: moves a body as the last Twist says, within limits, and has odometry.

    Attributes:
        obeys: the components of a command that the drive obeys; it does not look at the others.
        publishes_twist: whether it publishes its twist unless told otherwise.
    """

    obeys: ClassVar[Tuple[str, ...]]
    publishes_twist: ClassVar[bool] = True

    def on_initialize(self, config: YamlReader) -> None:
        """Reads the documented keys and opens the topics."""
        body = self.get_body(config)
        twist_sub = config.get_string("twist_sub", "cmd_vel")
        pub_rate = config.get_rate("pub_rate", math.inf)
        odometry = OdometryConfig.read(config, self.publishes_twist)
        self._command = self.add_drive(config, body)

        self._topic = self.node.resolve(twist_sub)
        self._odometry = OdometryPublisher(self, body, odometry)
        self.update_timer = UpdateTimer(pub_rate)
        self.node.subscribe(twist_sub, Twist, self._on_twist)

    @abstractmethod
    def add_drive(self, config: YamlReader, body: ModelBody) -> Callable[..., None]:
        """Reads the other keys, finishes the configuration and lets the core drive the body.

        Returns:
            What is to be called with the components of `obeys`; it raises ValueError for what it
            cannot obey.
        """

    def _on_twist(self, twist: Twist) -> None:
        told = {component: attrgetter(component)(twist) for component in self.obeys}
        try:
            self._command(*told.values())
        except ValueError as error:
            ignored = " ".join(f"{component}={value}" for component, value in told.items())
            logger.warning("%s: %s; ignored %s", self._topic, error, ignored)

    def has_work(self) -> bool:
        """Whether odometry is listened to, or drifts."""
        return self._odometry.has_work()

    def before_physics_step(self, timekeeper: Timekeeper) -> None:
        """Publishes odometry; the core drives."""
        self._odometry.publish(timekeeper.nanoseconds)

    def on_shutdown(self) -> None:
        """Stops, within the limits: the body may live on, and nobody commands it any more."""
        with contextlib.suppress(GoneError):
            self._command(*(0.0 for _ in self.obeys))


def read_dynamics(config: YamlReader) -> Tuple[DynamicsLimits, DynamicsLimits]:
    """The limits of a drive's linear and of its angular velocity."""
    return (
        DynamicsLimits.read(config, "linear_dynamics"),
        DynamicsLimits.read(config, "angular_dynamics"),
    )
