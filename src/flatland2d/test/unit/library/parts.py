"""A plugin, a robot with it and a room, for the tests of the library."""

from flatland2d import messages
from flatland_server import ModelPlugin, PluginDeclaration, PluginLoader

Float = messages.get("std_msgs/Float64")

BODY = {"name": "base", "footprints": [{"type": "circle", "radius": 0.2, "density": 5}]}
WALLS = "-2 -2 2 -2\n2 -2 2 2\n"


class Pusher(ModelPlugin):
    """Drives its body, publishes its speed, and fails at a negative command."""

    quantities = ("speed",)

    def on_initialize(self, config):
        self.speed = 0.0
        self.received = []
        config.finish()
        self.publisher = self.node.advertise("speed", Float)
        self.node.subscribe("command", Float, self.receive)

    def receive(self, message):
        self.received.append(message.data)
        self.command(message.data)

    def command(self, speed, turn=0.0):
        if speed > 9:
            raise ValueError("too fast")
        self.speed = speed

    def before_physics_step(self, timekeeper):
        if self.speed < 0:
            raise RuntimeError("cannot drive backwards")
        self.model.base.physics_body.velocity = (self.speed, 0.0, 0.0)
        if self.publisher.has_subscribers:
            self.publish_now(timekeeper)

    def publish_now(self, timekeeper):
        self.publisher.publish(Float(self.speed))

    def read(self, timekeeper):
        return timekeeper.nanoseconds

    def read_speed(self, timekeeper):
        return self.speed

    def get_state(self):
        return self.speed

    def set_state(self, state):
        self.speed = state


DISC = {"type": "circle", "radius": 0.3, "density": 1}
LASER = {"type": "Laser", "name": "laser", "body": "base", "range": 8}
SCANNER = {
    "bodies": [{"name": "base", "footprints": [DISC]}],
    "plugins": [
        {"type": "DiffDrive", "name": "drive", "body": "base"},
        {**LASER, "angle": {"min": -3.1, "max": 3.1, "increment": 0.2}},
    ],
}
"""A robot with built-in plugins."""


def room(*maps, layers=("map", "other"), model=SCANNER):
    """A world of a robot, with a map for each layer."""
    return {
        "properties": {},
        "layers": [{"name": name, "map": map} for name, map in zip(layers, maps)],
        "models": [{"name": "robot", "model": model}],
    }


LOADER = PluginLoader([PluginDeclaration.of(Pusher)])
ROBOT = {"bodies": [BODY], "plugins": [{"type": "Pusher", "name": "pusher"}]}
