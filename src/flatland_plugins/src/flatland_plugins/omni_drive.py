"""OmniDrive: a body that goes any way and turns meanwhile, as geometry_msgs/Twist commands it."""

from typing import Callable

from flatland_plugins.twist_drive import TwistDrive, read_dynamics
from flatland_server import ModelBody, YamlReader


class OmniDrive(TwistDrive):
    """Mecanum or swerve wheels: x is forwards and y to the left (REP 103).

    The keys are those of DiffDrive. `linear_dynamics` limits the velocity in the plane, not each of
    its components.
    """

    obeys = ("linear.x", "linear.y", "angular.z")

    def add_drive(self, config: YamlReader, body: ModelBody) -> Callable[..., None]:
        limits = read_dynamics(config)
        config.finish()
        return body.physics_body.add_drive(*limits).command
