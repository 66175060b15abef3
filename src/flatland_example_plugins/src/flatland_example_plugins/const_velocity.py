"""ConstVelocity: a body that moves at a constant velocity."""

from flatland_server import ModelPlugin, Timekeeper, YamlReader


class ConstVelocity(ModelPlugin):
    """Sets a body's velocity before each step, also if something has slowed it down."""

    def on_initialize(self, config: YamlReader) -> None:
        """Finds the body and reads its velocity in the world's frame [m/s, m/s, rad/s]."""
        self._body = self.get_body(config).physics_body
        self._velocity = (
            config.get_float("vel_x"),
            config.get_float("vel_y"),
            config.get_float("omega"),
        )

    def before_physics_step(self, timekeeper: Timekeeper) -> None:
        self._body.velocity = self._velocity

    def get_state(self) -> None:
        """Nothing: the simulator saves the motion of bodies."""
