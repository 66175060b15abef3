"""DiffDrive: a body that goes forwards and turns, as geometry_msgs/Twist commands it."""

from typing import Callable

from flatland_plugins.twist_drive import TwistDrive, read_dynamics
from flatland_server import ModelBody, YamlReader


class DiffDrive(TwistDrive):
    """Two wheels on an axle, or anything else that cannot go sideways."""

    obeys = ("linear.x", "angular.z")

    def add_drive(self, config: YamlReader, body: ModelBody) -> Callable[..., None]:
        limits = read_dynamics(config)
        config.finish()
        drive = body.physics_body.add_drive(*limits)
        return lambda forwards, turning: drive.command(forwards, 0.0, turning)
