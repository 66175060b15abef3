"""The `linear_dynamics` and `angular_dynamics` of a drive."""

from typing import NamedTuple

from flatland_server import YamlReader


class DynamicsLimits(NamedTuple):
    """How fast a velocity may change and how large it may be; 0 is no limit.

    Of a body's velocity in the plane, as a vector, in m/s^2 and m/s; or of an angular velocity, in
    rad/s^2 and rad/s.
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
