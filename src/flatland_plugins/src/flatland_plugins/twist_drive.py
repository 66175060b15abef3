"""The base of drives that are commanded by geometry_msgs/Twist."""

import contextlib
import logging
import math
from abc import ABC, abstractmethod
from typing import Any, Callable, ClassVar, Tuple

from flatland_plugins.drive_config import Actuators, read_dynamics
from flatland_plugins.odometry import OdometryPlugin
from flatland_plugins.odometry_config import OdometryConfig
from flatland_server import (
    BatchRole,
    CoreDrive,
    GoneError,
    ModelBody,
    UpdateTimer,
    YamlReader,
    messages,
)

Twist = messages.get("geometry_msgs/Twist")

logger = logging.getLogger(__name__)


class TwistDrive(OdometryPlugin, ABC):
    """Moves a body as the last Twist commands, within limits, and publishes its odometry.

    A drive overrides `add_drive` and `on_twist`.

    Attributes:
        publishes_twist: the default of `enable_twist_pub`.
        publishes_transform: the default of `enable_odom_tf_pub`.
    """

    publishes_twist: ClassVar[bool] = True
    publishes_transform: ClassVar[bool] = True

    def on_initialize(self, config: YamlReader) -> None:
        body = self.get_body(config)
        if body.config.type != "dynamic":
            effect = "never moves" if body.config.type == "static" else "is stopped by no wall"
            found = f"a {body.config.type} one, which {effect}"
            config.warn(f"expected a dynamic body, found {found}", "body")
        twist_sub = config.get_topic("twist_sub", "cmd_vel")
        pub_rate = config.get_rate("pub_rate", math.inf)
        self.read_frames(config)
        odometry = config.read_once(
            OdometryConfig.read,
            self.publishes_twist,
            self.publishes_transform,
            self.node.get_param("~odom_topic", "odometry/filtered"),
        )
        self._core_drive = self.add_drive(config, body)

        self.update_timer = UpdateTimer(pub_rate)
        slips = self._actuators.friction > 0.0
        self.open_odometry(body, odometry, self.update_timer.period, slips)
        self.subscribe_commands(twist_sub, "geometry_msgs/Twist", self.on_twist)

    @abstractmethod
    def add_drive(self, config: YamlReader, body: ModelBody) -> CoreDrive:
        """Reads the other keys, finishes the configuration, and adds a drive of the core.

        Calls `read_actuators`, after all getters and before `finish`.
        """

    def read_actuators(self, config: YamlReader, body: ModelBody, is_steered: bool = False) -> Any:
        """Reads the actuators, and returns them as the core's drives take them.

        Args:
            config: the drive's entry in the model file.
            body: body that the drive moves.
            is_steered: whether their angular axis is a steering angle.
        """
        self._actuators = config.read_once(Actuators.read, is_steered)
        if self._actuators.has_force and not body.physics_body.inertia:
            kind = body.config.type
            found = f"a {kind} one" if kind != "dynamic" else "one without"
            config.problem(
                f"a limited force needs a dynamic body with a density, found {found}", "actuators"
            )
        return self._actuators.for_core(self.rng)

    @property
    def batch_role(self) -> BatchRole:
        """The drive."""
        return BatchRole(drive=self._core_drive)

    @abstractmethod
    def on_twist(self, twist: Any) -> None:
        """Passes a command to the drive of the core.

        Raises:
            ValueError: the command cannot be obeyed, for example because it is not finite.
        """

    def describe(self, command: Any) -> str:
        """The components of a message that the drive obeys, for warnings."""
        return f"linear.x={command.linear.x} angular.z={command.angular.z}"

    def subscribe_commands(self, topic: str, kind: str, obey: Callable[[Any], None]) -> None:
        """Obeys the messages of a topic; warns of the first in a series of invalid ones.

        Args:
            topic: name of the topic of commands.
            kind: the type of its messages.
            obey: passes a message to the drive of the core; raises a ValueError for an invalid one.
        """
        is_ignoring = False

        def receive(command: Any) -> None:
            nonlocal is_ignoring
            try:
                obey(command)
            except ValueError as error:
                if not is_ignoring:
                    name, content = self.node.resolve(topic), self.describe(command)
                    logger.warning("%s: %s; ignored %s", name, error, content)
                is_ignoring = True
            else:
                is_ignoring = False

        self.node.subscribe(topic, kind, receive)

    def on_shutdown(self) -> None:
        """Stops the body within the limits, if it outlives the drive."""
        with contextlib.suppress(GoneError):
            self.on_twist(Twist())


class VelocityDrive(TwistDrive):
    """A drive that is given a velocity: of all three components, or of some.

    Attributes:
        columns: the components: 0 is forwards, 1 to the left, 2 the turn.
    """

    columns: ClassVar[Tuple[int, ...]]

    def add_drive(self, config: YamlReader, body: ModelBody) -> CoreDrive:
        linear, angular = config.read_once(read_dynamics)
        actuators = self.read_actuators(config, body)
        config.finish()
        self._drive = body.physics_body.add_drive(linear, angular, actuators)
        limits = (linear.velocity_limit, linear.velocity_limit, angular.velocity_limit)
        chosen = tuple(limits[k] for k in self.columns)
        return CoreDrive(self._drive, self.columns, chosen, self._actuators.is_random)
