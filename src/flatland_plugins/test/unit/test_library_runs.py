"""The same run through `Simulation`, and as the server makes it: equal to the last bit."""

import hashlib
from concurrent.futures import ThreadPoolExecutor

import pytest
from busy_town import Town, content_of

from flatland2d import Simulation
from flatland_server.simulation.simulation_manager import SimulationManager
from flatland_server.transport.local_transport import Tap

pytestmark = pytest.mark.slow


class Digest(Tap):
    """A digest of the messages and transforms of some topics."""

    def __init__(self, topics=None):
        self.topics = topics
        self.sha = hashlib.sha256()
        self.count = 0

    def wants(self, topic):
        return self.topics is None or topic in self.topics

    def receive(self, topic, message, is_latched):
        if not topic.endswith(("cmd_vel", "tween_trigger")):  # what is sent to the world
            self.add(topic, content_of(message))

    def receive_transform(self, transform):
        self.add(transform)

    def add(self, *what):
        self.count += 1
        self.sha.update(repr(what).encode())


class Library(Simulation):
    """A `Simulation` for the timetable of `Town`."""

    def drive(self, speed, turn, topic):
        name = topic.split("/")[1]
        self.models[name].drives["drive"].command(speed, turn)

    def send(self, topic, message):
        self.publish(topic, message)

    def run(self):
        self.step()


class LibraryTown(Town):
    """The town, stepped by a `Simulation`, with commands that are no messages."""

    def __init__(self, folder, seed=4):
        super().__init__(folder, seed)
        self.simulation.world.close()
        loader = self.files.loader
        self.simulation = Library(folder / "world.yaml", seed=seed, loader=loader)

    def run_and_digest(self, seconds, topics=None):
        """Advances the time; a digest of what was published, and of the world at the end."""
        transport, digest = self.simulation.transport, Digest(topics)
        transport.open_tap(digest)
        self.run(seconds)
        transport.close_tap(digest)
        digest.add(self.motion())
        assert topics is not None or digest.count > 100 * seconds
        return digest.sha.hexdigest()


class Server:
    """Steps a world as the server does, for the timetable of `Town`."""

    def __init__(self, simulation):
        self._simulation = simulation
        self._manager = SimulationManager(simulation.world, simulation.timekeeper)

    def run(self):
        self._manager.step()

    def __getattr__(self, name):
        return getattr(self._simulation, name)


class ServerTown(Town):
    """The town, stepped by a `SimulationManager`, with messages as commands."""

    run_and_digest = LibraryTown.run_and_digest

    def __init__(self, folder, seed=4):
        super().__init__(folder, seed)
        self.simulation = Server(self.simulation)


@pytest.mark.slow
def test_a_simulation_makes_the_run_of_the_server(tmp_path):
    assert LibraryTown(tmp_path).run_and_digest(2.0) == ServerTown(tmp_path).run_and_digest(2.0)


def read_everything(simulation):
    for model in simulation.models.values():
        for sensor in model.sensors.values():
            sensor.read()
            for quantity in sensor.quantities:
                sensor.read(quantity)
    _ = simulation.poses, simulation.velocities, simulation.contacts, simulation.topics


@pytest.mark.slow
def test_reading_changes_nothing(tmp_path, monkeypatch):
    silent = LibraryTown(tmp_path).run_and_digest(2.0)

    monkeypatch.setattr(Library, "run", lambda self: read_everything(self.step()))

    assert LibraryTown(tmp_path).run_and_digest(2.0) == silent


@pytest.fixture(scope="module")
def begin(world_of):
    """Begins a run in a world with noise; nothing is subscribed to."""
    world = world_of(noise="0.02")

    def begin(seed):
        made = Simulation(world, seed=seed)
        made.models["robot"].command(0.5, 0.01 * seed)
        return made

    return begin


def content(made):
    readings = [sensor.read() for sensor in made.models["robot"].sensors.values()]
    return repr([made.poses.tobytes(), made.velocities.tobytes(), made.contacts, readings])


def test_simulations_in_turns_and_in_threads_are_those_made_one_by_one(begin):
    alone = [content(begin(seed).step(200)) for seed in range(64)]

    in_turns = [begin(seed) for seed in range(3)]
    for _ in range(200):
        for each in in_turns:
            each.step()
    with ThreadPoolExecutor(8) as pool:
        together = list(pool.map(lambda seed: content(begin(seed).step(200)), range(64)))

    assert [content(each) for each in in_turns] == alone[:3]
    assert together == alone
    assert len(set(alone)) == 64
