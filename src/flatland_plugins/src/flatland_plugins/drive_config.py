"""The keys that drives share: limits of velocities, and what is between commands and wheels."""

from typing import NamedTuple, Optional, Tuple

import numpy as np

from flatland_plugins.timed_noise import draw_key
from flatland_server import YamlReader

_MAX_DELAY = 10.0
"""The longest delay [s], as in the core."""


class DynamicsLimits(NamedTuple):
    """`linear_dynamics` or `angular_dynamics`: limits of a velocity and its change; 0 is none.

    They apply to a body's velocity in the plane, as a vector, in m/s and m/s^2; or to an angular
    velocity, in rad/s and rad/s^2.
    """

    acceleration_limit: float
    deceleration_limit: float
    velocity_limit: float

    @classmethod
    def read(cls, config: YamlReader, key: str) -> "DynamicsLimits":
        """Reads the section; the deceleration limit defaults to the acceleration limit."""
        section = config.get_section(key)
        acceleration = section.get_float("acceleration_limit", 0.0, minimum=0.0)
        limits = cls(
            acceleration,
            section.get_float("deceleration_limit", acceleration, minimum=0.0),
            section.get_float("velocity_limit", 0.0, minimum=0.0),
        )
        section.finish()
        return limits


def read_dynamics(config: YamlReader) -> Tuple[DynamicsLimits, DynamicsLimits]:
    """The limits of a drive's linear and of its angular velocity."""
    return (
        DynamicsLimits.read(config, "linear_dynamics"),
        DynamicsLimits.read(config, "angular_dynamics"),
    )


class Axis(NamedTuple):
    """The actuator of the velocity in the plane, of the yaw rate, or of a steering angle."""

    delay: float
    """Dead time of commands [s]."""
    time_constant: float
    """Of a first-order lag [s]."""
    dead_band: float
    """Lower commands count as 0 [m/s or rad/s]; of a steering angle, nearer ones are ignored."""
    noise: float
    """Growth of the variance of the way while the robot drives [m^2/s or rad^2/s]."""


class Actuators(NamedTuple):
    """The section `actuators` of a drive; all numbers 0: it has none."""

    linear: Axis
    angular: Axis
    command_timeout: float
    """Time without a command after which the robot brakes [s]; 0: never."""
    max_force: float
    """Of the motors [N]; 0 is no limit, here and below."""
    max_torque: float
    """Of the motors, about the centre of mass [N m]."""
    friction: float
    """Coefficient of the tyres: with more force than friction allows, wheels slip."""

    @classmethod
    def read(cls, config: YamlReader, is_steered: bool = False) -> "Actuators":
        """Reads the section.

        Args:
            config: the drive's entry in the model file.
            is_steered: whether the angular axis is a steering angle, which has no noise.
        """
        section = config.get_section("actuators")
        shared = tuple(_time(section, key, 0.0) for key in ("delay", "time_constant"))
        linear = _read_axis(section.get_section("linear"), shared)
        angular = _read_axis(section.get_section("angular"), shared, has_noise=not is_steered)
        timeout, max_force, max_torque = (
            section.get_float(key, 0.0, minimum=0.0)
            for key in ("command_timeout", "max_force", "max_torque")
        )
        traction = section.get_section("traction")
        friction = traction.get_float("friction", 0.0, minimum=0.0)
        traction.finish()
        section.finish()
        return cls(linear, angular, timeout, max_force, max_torque, friction)

    @property
    def is_random(self) -> bool:
        """True if they have noise."""
        return self.linear.noise > 0.0 or self.angular.noise > 0.0

    @property
    def has_force(self) -> bool:
        """True if the force or the torque has a limit."""
        return any((self.max_force, self.max_torque, self.friction))

    def for_core(
        self, rng: np.random.Generator
    ) -> Optional[Tuple[Axis, Axis, float, int, Tuple[float, ...]]]:
        """The arguments of the core's drives, or None if there are no actuators.

        Args:
            rng: of the plugin; the first number of it is the key of the noise, if there is some.
        """
        linear, angular, timeout, *force = self
        if not any((*linear, *angular, timeout, *force)):
            return None
        return linear, angular, timeout, draw_key(rng) if self.is_random else 0, tuple(force)


def _read_axis(section: YamlReader, shared: Tuple[float, ...], has_noise: bool = True) -> Axis:
    delay, time_constant = shared
    axis = Axis(
        _time(section, "delay", delay),
        _time(section, "time_constant", time_constant),
        section.get_float("dead_band", 0.0, minimum=0.0),
        section.get_float("noise", 0.0, minimum=0.0) if has_noise else 0.0,
    )
    section.finish()
    return axis


def _time(section: YamlReader, key: str, default: float) -> float:
    value = section.get_float(key, default, minimum=0.0)
    if key == "delay" and section.has(key) and value > _MAX_DELAY:
        section.problem(f"expected {_MAX_DELAY:g} s at most, found {value:g}", key)
    return value
