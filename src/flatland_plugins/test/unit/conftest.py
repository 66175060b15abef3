"""What the unit tests of the plugins share: a robot in a world, and simulated time."""

import textwrap
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional, Tuple, Type

import hypothesis
import pytest
from geometry_msgs.msg import Twist

from flatland_server.exceptions import FlatlandError
from flatland_server.models.model import Model
from flatland_server.plugins.plugin_loader import PluginLoader
from flatland_server.simulation.world import World
from flatland_server.timekeeper import Timekeeper
from flatland_server.transport.local_transport import LocalTransport
from flatland_server.transport.node import Publisher

pytest.register_assert_rewrite("bumping", "forklift", "readings")

# Equal cases in every run, and no files left behind.
hypothesis.settings.register_profile("flatland", derandomize=True, database=None, deadline=None)
hypothesis.settings.load_profile("flatland")

WORLDS = Path(__file__).resolve().parents[3] / "flatland_server" / "worlds"
DISC = "{type: circle, radius: 0.2, density: 10}"


class Simulation:
    """A world that is stepped, with the messages that wait for it."""

    def __init__(self, world: World, step_size: float = 0.005) -> None:
        self.world = world
        self.timekeeper = Timekeeper(step_size)

    @property
    def transport(self) -> LocalTransport:
        """What the world publishes to."""
        assert isinstance(self.world.transport, LocalTransport)
        return self.world.transport

    def run(self, seconds: Optional[float] = None) -> "Simulation":
        """Lets simulated time pass: one step, or so many seconds."""
        steps = 1 if seconds is None else round(seconds / self.timekeeper.step_size)
        for _ in range(steps):
            self.world.transport.process()
            self.world.step(self.timekeeper)
        return self

    def record(self, topic: str, seconds: float) -> List[Any]:
        """The messages that a topic has while simulated time passes."""
        messages: List[Any] = []
        for _ in range(round(seconds / self.timekeeper.step_size)):
            self.run()
            message = self.last(topic)
            if message is not None and (not messages or message is not messages[-1]):
                messages.append(message)
        return messages

    def drive(self, linear: float, angular: float = 0.0, topic: str = "/cmd_vel") -> "Simulation":
        """Commands a velocity, to be obeyed from the next step on."""
        twist = Twist()
        twist.linear.x, twist.angular.z = linear, angular
        self.transport.send(topic, twist)
        return self

    def last(self, topic: str) -> Any:
        """The newest message of a topic."""
        return self.transport.last(topic)

    def model(self, name: str = "robot") -> Model:
        """A model, the robot if not told otherwise."""
        return self.world.models[name]


class WorldFiles:
    """A folder of world, model and map files."""

    def __init__(self, folder: Path, loader: PluginLoader) -> None:
        self.folder = folder
        self._loader = loader

    def write(self, name: str, text: str) -> Path:
        """Writes a file; the text may be indented as a whole."""
        path = self.folder / name
        path.write_text(textwrap.dedent(text).lstrip("\n"), encoding="utf-8")
        return path

    def walls(self, name: str, *segments: str) -> str:
        """Writes line segments "x1 y1 x2 y2", and returns the map's file."""
        self.write(f"{name}.dat", "\n".join(segments))
        map_text = f"type: line_segments\ndata: {name}.dat\nscale: 1\norigin: [0, 0, 0]\n"
        return self.write(f"{name}.yaml", map_text).name

    def model(self, name: str, *plugins: str, footprint: str = DISC, body: str = "") -> str:
        """Writes a model of one body "base" with plugins, one a line from line 5 on."""
        lines = "".join(f"\n  - {{{plugin}}}" for plugin in plugins) or " []"
        text = (
            f"bodies:\n  - {{name: base, {body}\n     footprints: [{footprint}]}}\nplugins:{lines}"
        )
        return self.write(f"{name}.model.yaml", text + "\n").name

    def load(
        self, models: Dict[str, str], layers: Tuple[str, ...] = (), **options: Any
    ) -> Simulation:
        """A world of models, given as the rest of their entries by name, and of layers."""
        lines = ["properties: {}", "layers:" if layers else "layers: []"]
        lines += [f"  - {{{layer}}}" for layer in layers]
        lines += ["models:"]
        lines += [f"  - {{name: {name}, {entry}}}" for name, entry in models.items()]
        path = self.write("world.yaml", "\n".join(lines))
        return Simulation(World.from_file(path, **{"loader": self._loader, **options}))

    def robot(
        self,
        *plugins: str,
        footprint: str = DISC,
        namespace: str = "",
        pose: str = "[0, 0, 0]",
        layers: Tuple[str, ...] = (),
        others: Optional[Dict[str, str]] = None,
        **options: Any,
    ) -> Simulation:
        """A world with a robot of these plugins in it, and perhaps other models after it."""
        model = self.model("robot", *plugins, footprint=footprint)
        entry = f"model: {model}, namespace: '{namespace}', pose: {pose}"
        return self.load({"robot": entry, **(others or {})}, layers, **options)

    def refusal(self, *plugins: str) -> str:
        """Why a robot of these plugins is not loaded, without the folder's name."""
        with pytest.raises(FlatlandError) as caught:
            self.robot(*plugins)
        return str(caught.value).replace(f"{self.folder}/", "")


class DeafTransport(LocalTransport):
    """Nobody listens to its topics, or to its transforms; counts what is published all the same."""

    def __init__(self) -> None:
        super().__init__()
        self.published: List[str] = []
        self.publishers: List[_DeafPublisher] = []

    def advertise(self, topic: str, message_type: Any, **options: Any) -> Any:
        publisher = super().advertise(topic, message_type, **options)
        self.publishers.append(_DeafPublisher(self, topic, publisher))
        return self.publishers[-1]

    @property
    def transforms_have_subscribers(self) -> bool:
        return False

    @property
    def subscriber_revision(self) -> object:
        return object()  # tests let publishers be watched without a word


class _DeafPublisher(Publisher):
    has_subscribers = False

    def __init__(self, transport: DeafTransport, topic: str, publisher: Any) -> None:
        self._transport = transport
        self._topic = topic
        self._publisher = publisher

    def publish(self, message: Any) -> None:
        self._transport.published.append(self._topic)
        self._publisher.publish(message)

    def close(self) -> None:
        self._publisher.close()


@pytest.fixture(scope="session")
def loader() -> PluginLoader:
    """The plugins of this workspace, looked up once."""
    return PluginLoader()


@pytest.fixture
def files(tmp_path: Path, loader: PluginLoader) -> WorldFiles:
    return WorldFiles(tmp_path, loader)


@pytest.fixture
def deaf_transport() -> DeafTransport:
    return DeafTransport()


@pytest.fixture
def simulate() -> Type[Simulation]:
    """Makes a `Simulation` of a world."""
    return Simulation


@pytest.fixture
def town(files, simulate) -> Callable[..., Any]:
    """Makes a world of people, the first one on line 8 of its file."""

    def load(
        *people: str,
        keys: str = "",
        walls: Tuple[str, ...] = (),
        robots: Dict[str, str] = {},  # noqa: B006 (only read)
        **options: Any,
    ) -> Any:
        layer = f"{{name: map, map: {files.walls('map', *walls)}}}" if walls else "{name: map}"
        lines = [
            "properties: {}",
            f"layers: [{layer}, {{name: other}}]",
            f"models: [{', '.join(f'{{name: {n}, {entry}}}' for n, entry in robots.items())}]",
            "plugins:",
            "  - type: Crowd",
            f"    <<: {{{keys}}}",
            "    pedestrians:" + (" []" if not people else ""),
            *(f"      - {{{person}}}" for person in people),
            "    name: people",
        ]
        path = files.write("world.yaml", "\n".join(lines))
        return simulate(World.from_file(path, **{"loader": files._loader, **options}))

    return load


@pytest.fixture
def empty_room(loader: PluginLoader) -> Simulation:
    """The turtlebot in the middle of an empty room of 10 x 6 m."""
    return Simulation(World.from_file(WORLDS / "test_room" / "world.yaml", loader=loader))


@pytest.fixture
def office(loader: PluginLoader) -> Simulation:
    """The default world."""
    return Simulation(World.from_file(WORLDS / "office" / "world.yaml", loader=loader))
