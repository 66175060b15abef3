"""The `linear_dynamics` and `angular_dynamics` of a drive."""

from typing import NamedTuple

from flatland_server import YamlReader


class DynamicsLimits(NamedTuple):
    """Limits of a velocity and of its rate of change; 0 is no limit.

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
