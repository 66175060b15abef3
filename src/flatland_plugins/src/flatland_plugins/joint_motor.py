"""JointMotor: turns a revolute joint, at a velocity or to a position."""

import logging
import math
from typing import Any, Optional

from flatland_server import BatchRole, ModelPlugin, Timekeeper, YamlReader

logger = logging.getLogger(__name__)


class JointMotor(ModelPlugin):
    """Obeys std_msgs/Float64 on a topic: a velocity [rad/s], or a position [rad].

    The motor is that of Box2D's joint: it turns the joint's second body relative to the first one,
    with a limited torque. It is off until the first command; a velocity of 0 brakes.
    """

    def on_initialize(self, config: YamlReader) -> None:
        joint = self.get_joint(config, "joint")
        if joint is not None and joint.config.type != "revolute":
            config.problem(f"expected a revolute joint, found a {joint.config.type}", "joint")
        mode = config.get_choice("mode", ["velocity", "position"], "velocity")
        self._is_position = mode == "position"
        self._max_torque = config.get_float("max_torque", above=0.0)
        self._max_velocity = config.get_float("max_velocity", 0.0, minimum=0.0) or math.inf
        topic = config.get_topic("topic", f"{self.name}/command")
        config.finish()
        assert joint is not None  # or there was a problem
        self._hinge = joint.physics_joint
        self._target: Optional[float] = None
        self._topic = self.node.resolve(topic)
        self.node.subscribe(topic, "std_msgs/Float64", self._receive)

    @property
    def batch_role(self) -> Optional[BatchRole]:
        """None for a position: the motor's speed is set in each step."""
        return None if self._is_position else BatchRole()

    def move(self, target: float) -> None:
        """Turns at a velocity [rad/s] or to a position [rad], by the mode.

        Raises:
            ValueError: it is not finite; nothing has changed.
        """
        if not abs(target) < 1e9:
            raise ValueError(f"expected a finite number, found {target}")
        self._target = target
        if not self._is_position:
            self._turn(target)

    def _turn(self, velocity: float) -> None:
        most = self._max_velocity
        self._hinge.motor = (max(-most, min(most, velocity)), self._max_torque)

    def _receive(self, message: Any) -> None:
        try:
            self.move(message.data)
        except ValueError as error:
            logger.warning("%s: %s; ignored", self._topic, error)

    def has_work(self) -> bool:
        """True for positions: where the joint is decides about its speed."""
        return self._is_position

    def before_physics_step(self, timekeeper: Timekeeper) -> None:
        """Chooses the velocity that leads to the position in this step, within the limit."""
        if self._target is None:
            return
        angle, limits = self._hinge.angle, self._hinge.limits
        if limits is None:
            way = math.remainder(self._target - angle, math.tau)  # the shorter way round
        else:  # the angle with its whole rotations is the one near the middle of the limits
            middle = sum(limits) / 2.0
            target = max(limits[0], min(limits[1], self._target))
            way = target - middle - math.remainder(angle - middle, math.tau)
        self._turn(way / timekeeper.step_size)

    def get_state(self) -> Optional[float]:
        """The position to reach; the core saves the motor."""
        return self._target

    def set_state(self, state: Optional[float]) -> None:
        self._target = state
