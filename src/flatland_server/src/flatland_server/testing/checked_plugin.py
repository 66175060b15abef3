"""A plugin in a world, to be checked: its entry, and variants of it."""

import copy
from pathlib import Path
from typing import (
    Any,
    Callable,
    Collection,
    Dict,
    Iterator,
    List,
    Mapping,
    NamedTuple,
    Optional,
    Tuple,
    Union,
)

import yaml

from flatland_server.exceptions import FlatlandError
from flatland_server.geometry import Pose
from flatland_server.plugins.plugin import Plugin
from flatland_server.plugins.plugin_loader import PluginLoader
from flatland_server.simulation.world import World, WorldPlugin
from flatland_server.testing.files import DISC, WorldFiles
from flatland_server.testing.harness import Harness
from flatland_server.testing.observation import ObservingLoader, ObservingTransport

KeyPath = Tuple[Union[str, int], ...]
"""The place of a key in an entry, such as ("angle", "min") or ("pedestrians", 0, "pose")."""

Document = Dict[str, Any]

ROBOT = "robot"
"""The name of the model with the checked plugin."""

_LOADER: Any = getattr(yaml, "CBaseLoader", yaml.BaseLoader)  # for the lines alone

_DISC_MODEL = f"bodies: [{{name: base, footprints: [{DISC}]}}]"

_COMMON_KEYS = ("type", "name", "enabled")


class Names(NamedTuple):
    """The topics and frames of a plugin."""

    published: Tuple[str, ...]
    subscribed: Tuple[str, ...]
    transforms: Tuple[Tuple[str, str], ...]
    message_frames: Tuple[Tuple[str, str], ...]
    """The topics, and the frames that their messages name."""


class ObservedRun(NamedTuple):
    """A simulation of the plugin, with the objects that observe it."""

    simulation: Harness
    transport: ObservingTransport
    loader: ObservingLoader

    def go(self, seconds: float) -> "ObservedRun":
        """Sends a command to each topic that the plugin subscribes to, and advances the time."""
        for topic in sorted(self.transport.subscribed):
            self.simulation.send(topic, filled(self.transport.types[topic](), 0.2))
        self.simulation.run(seconds)
        return self

    @property
    def names(self) -> Names:
        """The topics and frames that were used so far."""
        frames = set()
        for event in self.transport.events:
            header = getattr(event.message, "header", None)
            for owner, field in ((header, "frame_id"), (event.message, "child_frame_id")):
                if hasattr(owner, field):
                    frames.add((event.topic, getattr(owner, field)))
        edges = {(t.parent, t.child) for _, _, t in self.transport.sent_transforms}
        return Names(
            tuple(sorted(self.transport.topics)),
            tuple(sorted(self.transport.subscribed)),
            tuple(sorted(edges)),
            tuple(sorted(frames)),
        )


class CheckedPlugin:
    """A plugin, and the world in which it is checked.

    Args:
        entry: entry of the plugin, with its type and name.
        model: of the robot: its file without plugins; by default a disc called "base".
        world: its file without the robot; by default a room of 10 x 10 m, its walls on the layer
            "map".
        files: other files by their names.
        loader: finds plugin classes.
        other_keys: names of keys that the plugin reads and the entry does not show.
    """

    def __init__(
        self,
        entry: Mapping[str, Any],
        model: Optional[Mapping[str, Any]],
        world: Optional[Mapping[str, Any]],
        files: Mapping[str, str],
        loader: Optional[PluginLoader],
        other_keys: Collection[str],
    ) -> None:
        self.entry: Document = dict(entry)
        self.other_keys = other_keys
        self._written: Dict[str, Document] = {}
        self.files = WorldFiles(loader=loader)
        for name, content in files.items():
            self.files.write(name, content)
        self._model = dict(model or yaml.safe_load(_DISC_MODEL))
        self._world = dict(world or self._room())
        plugin_class = self.files.loader.load(str(self.entry["type"]), Plugin)
        self.is_of_world = issubclass(plugin_class, WorldPlugin)
        self.file = "world.yaml" if self.is_of_world else "robot.model.yaml"
        """The file that the entry is in."""
        self._empty: Optional[World] = None

    def _room(self) -> Document:
        corners = [(-5, -5), (5, -5), (5, 5), (-5, 5)]
        walls = [(*a, *b) for a, b in zip(corners, [*corners[1:], corners[0]])]
        return {"layers": [{"name": "map", "map": self.files.walls("room", *walls)}]}

    def write(self, entry: Document, namespace: str = "") -> Path:
        """Writes the files with an entry, and returns the world's."""
        robot = {"name": ROBOT, "model": "robot.model.yaml", "namespace": namespace}
        world = {"properties": {}, "layers": [], **self._world}
        world["models"] = [robot, *world.get("models", [])]
        model = dict(self._model)
        (world if self.is_of_world else model)["plugins"] = [entry]
        documents = {"robot.model.yaml": model, "world.yaml": world}
        for name, document in documents.items():
            if self._written.get(name) != document:
                self.files.write(name, document)
                self._written[name] = document
        return self.files.folder / "world.yaml"

    def load(
        self,
        entry: Optional[Document] = None,
        *,
        namespace: str = "",
        seed: int = 0,
        has_subscribers: bool = True,
    ) -> ObservedRun:
        """A new simulation, with another entry if one is given.

        Raises:
            FlatlandError: the entry is refused.
        """
        path = self.write(self.entry if entry is None else entry, namespace)
        transport = ObservingTransport(None if has_subscribers else ())
        loader = ObservingLoader(self.files.loader, str(self.entry["type"]))
        world = World.from_file(path, transport, seed=seed, loader=loader)
        simulation = Harness(world)
        transport.timekeeper = simulation.timekeeper
        simulation.after_step.append(transport.count_step)
        return ObservedRun(simulation, transport, loader)

    def spawn(self, simulation: Harness) -> None:
        """Puts the robot into a world, from which it was deleted."""
        path = self.files.folder / "robot.model.yaml"
        simulation.world.spawn_model(path, ROBOT, "", Pose())

    def refusal(self, entry: Document) -> List[str]:
        """The lines of the message that an entry is refused with; none if it is loaded.

        Exceptions other than a FlatlandError are passed on. A model's plugin is
        spawned with its model into a world that is loaded once: the walls are read once.
        """
        try:
            if self.is_of_world:
                self.load(entry).simulation.world.close()
            else:
                self._spawn_and_delete(entry)
        except FlatlandError as error:
            return str(error).replace(f"{self.files.folder}/", "").splitlines()
        return []

    def _spawn_and_delete(self, entry: Document) -> None:
        if self._empty is None:
            without_robot = {"properties": {}, "layers": [], **self._world}
            path = self.files.write("empty.world.yaml", without_robot)
            self._empty = World.from_file(path, ObservingTransport(()), loader=self.files.loader)
        self.write(entry)
        path = self.files.folder / "robot.model.yaml"
        self._empty.spawn_model(path, ROBOT, "", Pose())
        self._empty.delete_model(ROBOT)

    def close(self) -> None:
        """Ends what was started for several checks."""
        if self._empty is not None:
            self._empty.close()

    def lines(self, path: KeyPath) -> Tuple[int, int]:
        """The lines in which a key of the entry that was loaded last, and its value, begin."""
        text = (self.files.folder / self.file).read_text(encoding="utf-8")
        node: Any = yaml.compose(text, _LOADER)
        line = 0
        for step in ("plugins", 0, *path):
            if isinstance(step, int):
                node = node.value[step]
                continue
            [(key, node)] = [pair for pair in node.value if pair[0].value == step]
            line = key.start_mark.line + 1
        return line, node.start_mark.line + 1

    def names_of_parts(self) -> List[str]:
        """The names of the robot's bodies and joints."""
        parts = [*self._model.get("bodies", []), *self._model.get("joints", [])]
        return [str(part["name"]) for part in parts]


def keys_of(entry: Any, path: KeyPath = ()) -> Iterator[KeyPath]:
    """All keys of an entry, at any depth, but those that every plugin has."""
    if isinstance(entry, dict):
        for key, value in entry.items():
            if path or key not in _COMMON_KEYS:
                yield (*path, key)
                yield from keys_of(value, (*path, key))
    elif isinstance(entry, list):
        for index, item in enumerate(entry):
            if isinstance(item, (dict, list)):
                yield from keys_of(item, (*path, index))


def key_name(path: KeyPath) -> str:
    """A key's name with those of the maps around it, such as "angle.min"."""
    return ".".join(step for step in path if isinstance(step, str))


def value_at(entry: Document, path: KeyPath) -> Any:
    """The value of a key."""
    value: Any = entry
    for step in path:
        value = value[step]
    return value


def changed(entry: Document, path: KeyPath, change: Callable[[Any, Any], None]) -> Document:
    """A copy of an entry, after `change(map around the key, key)`."""
    new = copy.deepcopy(entry)
    change(value_at(new, path[:-1]), path[-1])
    return new


def with_value(entry: Document, path: KeyPath, value: Any) -> Document:
    """A copy of an entry with another value of a key."""
    return changed(entry, path, lambda around, key: around.update({key: value}))


def without(entry: Document, path: KeyPath) -> Document:
    """A copy of an entry without a key."""
    return changed(entry, path, lambda around, key: around.pop(key))


def with_key(entry: Document, path: KeyPath, name: str) -> Document:
    """A copy of an entry with another name of a key."""
    return changed(entry, path, lambda around, key: around.update({name: around.pop(key)}))


def filled(message: Any, value: float) -> Any:
    """A message, after all its floating-point numbers were set, and all its flags."""
    for name in getattr(message, "__slots__", ()):
        field = getattr(message, name)
        if isinstance(field, bool):
            setattr(message, name, True)
        elif isinstance(field, float):
            setattr(message, name, value)
        elif hasattr(field, "__slots__"):
            filled(field, value)
    return message
