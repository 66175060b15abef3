"""JointStatePublisher: angles, velocities and torques of revolute joints."""

import math
from typing import List, NamedTuple, Tuple

from flatland_server import (
    BatchRole,
    Joint,
    ModelError,
    ModelPlugin,
    Timekeeper,
    UpdateTimer,
    YamlReader,
    header,
    messages,
)

JointState = messages.get("sensor_msgs/JointState")


class JointStates(NamedTuple):
    """States of joints, in the order of their names."""

    name: Tuple[str, ...]
    position: Tuple[float, ...]
    """Angles of the second bodies relative to the first, in [-pi, pi] [rad]."""
    velocity: Tuple[float, ...]
    """[rad/s]"""
    effort: Tuple[float, ...]
    """Torques of the motors in the last step [N m]."""


class JointStatePublisher(ModelPlugin):
    """Publishes sensor_msgs/JointState of a model's revolute joints, as of real encoders."""

    batch_role = BatchRole()

    def on_initialize(self, config: YamlReader) -> None:
        topic = config.get_topic("topic", "joint_states")
        update_rate = config.get_rate("update_rate", math.inf)
        revolute = [each.name for each in self.model.joints if _is_revolute(each)]
        self._joints: List[Joint] = []
        for name in config.get_strings("joints", ()) or revolute:
            try:
                joint = self.model.get_joint(name)
            except ModelError as error:
                config.problem(str(error), "joints")
                continue
            if not _is_revolute(joint):
                config.problem(f'expected revolute joints, found "{name}", a weld', "joints")
            self._joints.append(joint)
        config.finish()
        self.update_timer = UpdateTimer(update_rate)
        self._frame_id = self.name_space_tf(self.model.base.name)
        self._names = tuple(each.name for each in self._joints)
        self._publisher = self.node.advertise(topic, "sensor_msgs/JointState")

    def has_work(self) -> bool:
        """True if the topic has a subscriber."""
        return self._publisher.has_subscribers

    def after_physics_step(self, timekeeper: Timekeeper) -> None:
        """Publishes the states at the end of the step."""
        self.publish_now(timekeeper)

    def publish_now(self, timekeeper: Timekeeper) -> None:
        name, position, velocity, effort = map(list, self.read(timekeeper))
        head = header(timekeeper.nanoseconds, self._frame_id)
        self._publisher.publish(
            JointState(header=head, name=name, position=position, velocity=velocity, effort=effort)
        )

    def read(self, timekeeper: Timekeeper) -> JointStates:
        """The present states."""
        hinges = [each.physics_joint for each in self._joints]
        return JointStates(
            self._names,
            tuple(each.angle for each in hinges),
            tuple(each.speed for each in hinges),
            tuple(each.motor_torque for each in hinges),
        )

    def get_state(self) -> None:
        """Nothing: the states are those of the present."""


def _is_revolute(joint: Joint) -> bool:
    return joint.config.type == "revolute"
