"""A world with models that clients move, spawn and delete."""

from types import SimpleNamespace

from direct_transport import DirectTransport

from flatland_server.hub.assembly import open_hub
from flatland_server.hub.client_files import ClientFiles
from flatland_server.simulation.simulation_manager import SimulationManager
from flatland_server.timekeeper import Timekeeper

BOX = "bodies: [{name: base, footprints: [{type: circle, radius: 0.2, density: 1}]}]\n"


class Server:
    """The services of a world of a text."""

    def __init__(self, files, text, state_folder=None):
        files.write("box.yaml", BOX)
        self.world = files.load(text, transport=DirectTransport())
        self.path = self.world.config.path
        self.manager = SimulationManager(self.world, Timekeeper(0.01))
        files = ClientFiles(self.world, state_folder)
        self.hub = open_hub(self.manager, files, control_period=0.1)
        self.edits = self.hub.edits
        self.opened = []
        self.hub.on_open.append(self.opened.append)

    def move(self, name, x, y, theta=0.0):
        pose = SimpleNamespace(x=x, y=y, theta=theta)
        self.call("move_model", name=name, pose=pose)

    def spawn(self, name, x, y, *, path="box.yaml", ns=""):
        pose = SimpleNamespace(x=x, y=y, theta=0.0)
        self.call("spawn_model", yaml_path=path, name=name, ns=ns, pose=pose)

    def delete(self, name):
        self.call("delete_model", name=name)

    def reset(self):
        self.call("reset", new_seed=False, seed=0, restart_time=True)

    def call(self, service, /, **fields):
        """Calls a service."""
        return self.hub.services[service].action(SimpleNamespace(**fields))

    def save(self, path=""):
        return self.call("save_world", path=str(path))["message"]

    @property
    def text(self):
        return self.path.read_text()

    def poses(self):
        return {name: model.pose for name, model in self.world.models.items()}
