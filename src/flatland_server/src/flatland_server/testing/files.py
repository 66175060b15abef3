"""World, model and map files of a test, in a temporary folder."""

import shutil
import tempfile
import textwrap
import weakref
from pathlib import Path
from typing import Any, Callable, Iterable, Mapping, Optional, Sequence, Tuple, Union

import yaml

from flatland_server.exceptions import FlatlandError
from flatland_server.plugins.plugin_loader import PluginLoader, shared_loader
from flatland_server.simulation.world import World
from flatland_server.testing.harness import Harness

Entry = Union[str, Mapping[str, Any]]
"""A YAML map: as a dict, or as a string; the outer braces may be left out."""

Segment = Union[str, Sequence[float]]
"""A wall [m]: (x1, y1, x2, y2), or the same as a string."""

_DUMPER: Any = getattr(yaml, "CSafeDumper", yaml.SafeDumper)
"""libyaml's where PyYAML has it, which is ten times as fast."""

DISC = "{type: circle, radius: 0.2, density: 10}"
"""The footprint of a robot by default."""


class WorldFiles:
    """A folder of world, model and map files.

    Args:
        folder: an existing folder; by default a temporary one, removed with this object.
        loader: finds plugin classes; by default those that packages export.
        step_size: the simulations' step size [s].
    """

    def __init__(
        self,
        folder: Optional[Path] = None,
        loader: Optional[PluginLoader] = None,
        step_size: float = 0.005,
    ) -> None:
        if folder is None:
            folder = Path(tempfile.mkdtemp(prefix="flatland_"))
            weakref.finalize(self, shutil.rmtree, folder, ignore_errors=True)
        self.folder = folder
        self.loader = loader or shared_loader()
        self.step_size = step_size

    def write(self, name: str, content: Union[str, Mapping[str, Any]]) -> Path:
        """Writes a file.

        Args:
            name: name of the file, relative to the folder.
            content: a dict is written as YAML, a string without its common indentation.
        """
        if not isinstance(content, str):
            content = dump(content)
        path = self.folder / name
        path.write_text(textwrap.dedent(content).lstrip("\n"), encoding="utf-8")
        return path

    def walls(self, name: str, *segments: Segment) -> str:
        """Writes a map of walls, and returns its file's name, for the `map` of a layer.

        Args:
            name: of the file, without ".yaml".
            segments: the walls [m]: shape (n, 4), x1, y1, x2, y2.
        """
        lines = [each if isinstance(each, str) else " ".join(map(repr, each)) for each in segments]
        self.write(f"{name}.dat", "\n".join(lines))
        map_text = f"type: line_segments\ndata: {name}.dat\nscale: 1\norigin: [0, 0, 0]\n"
        return self.write(f"{name}.yaml", map_text).name

    def model(self, name: str, *plugins: Entry, footprint: str = DISC, body: str = "") -> str:
        """Writes a model of one body "base", and returns its file's name.

        Args:
            name: of the file, without ".model.yaml".
            plugins: its plugins, each on a line of its own from line 5 on.
            footprint: one or more footprints, separated by commas, as YAML.
            body: further keys of the body as YAML, such as "type: static,".
        """
        lines = "".join(f"\n  - {flow(plugin)}" for plugin in plugins) or " []"
        text = (
            f"bodies:\n  - {{name: base, {body}\n     footprints: [{footprint}]}}\nplugins:{lines}"
        )
        return self.write(f"{name}.model.yaml", text + "\n").name

    def load(self, world: Union[str, Mapping[str, Any]], **options: Any) -> Harness:
        """Loads a world.

        Args:
            world: its file's content, as a dict or as YAML.
            options: of `World.from_file`, such as `seed=3`.

        Raises:
            FlatlandError: the world is refused.
        """
        path = self.write("world.yaml", world)
        loaded = World.from_file(path, **{"loader": self.loader, **options})
        simulation = Harness(loaded, self.step_size)
        simulation.files = self  # plugins may read them later
        return simulation

    def load_models(
        self, models: Mapping[str, Entry], layers: Iterable[Entry] = (), **options: Any
    ) -> Harness:
        """Loads a world of models and layers.

        Args:
            models: the entries of models by their names, such as `{"robot": {"model": path}}`.
            layers: the entries of layers, such as `{"name": "map", "map": files.walls(...)}`.
            options: of `World.from_file`.
        """
        layer_lines = [f"  - {flow(layer)}" for layer in layers]
        lines = ["properties: {}", "layers:" if layer_lines else "layers: []", *layer_lines]
        lines += ["models:"]
        lines += [f"  - {{name: {name}, {flow(entry)[1:]}" for name, entry in models.items()]
        return self.load("\n".join(lines), **options)

    def robot(
        self,
        *plugins: Entry,
        footprint: str = DISC,
        namespace: str = "",
        pose: Union[str, Tuple[float, float, float]] = (0.0, 0.0, 0.0),
        walls: Sequence[Segment] = (),
        layers: Iterable[Entry] = (),
        others: Optional[Mapping[str, Entry]] = None,
        **options: Any,
    ) -> Harness:
        """Loads a world with a model "robot" of one body "base", which has these plugins.

        Args:
            plugins: the entries of its plugins.
            footprint: its body's footprint.
            namespace: of its topics and frames.
            pose: where it stands [m, m, rad].
            walls: segments [m] of a layer "walls".
            layers: further layers.
            others: further models, as for `load_models`.
            options: of `World.from_file`.

        Raises:
            FlatlandError: a plugin is refused.
        """
        model = self.model("robot", *plugins, footprint=footprint)
        pose = pose if isinstance(pose, str) else str(list(pose))
        entry = f"model: {model}, namespace: '{namespace}', pose: {pose}"
        all_layers = list(layers)
        if walls:
            all_layers.insert(0, f"name: walls, map: {self.walls('walls', *walls)}")
        return self.load_models({"robot": entry, **(others or {})}, all_layers, **options)

    def refusal(self, world: Union[str, Mapping[str, Any]], **options: Any) -> str:
        """The message with which a world is refused, without the folder's path.

        Args:
            world: its file's content, as a dict or as YAML.
            options: of `World.from_file`.

        Raises:
            AssertionError: it was loaded.
        """
        return self._refusal(lambda: self.load(world, **options))

    def robot_refusal(self, *plugins: Entry, **options: Any) -> str:
        """The message with which a robot of these plugins is refused, without the folder's path.

        Args:
            plugins: the entries of its plugins.
            options: of `WorldFiles.robot`.

        Raises:
            AssertionError: it was loaded.
        """
        return self._refusal(lambda: self.robot(*plugins, **options))

    def _refusal(self, load: Callable[[], object]) -> str:
        try:
            load()
        except FlatlandError as error:
            return str(error).replace(f"{self.folder}/", "")
        raise AssertionError("expected a FlatlandError, but the world was loaded")


def load(world: Union[str, Mapping[str, Any]], **options: Any) -> Harness:
    """Loads a world in a folder of its own; see `WorldFiles.load`.

    Args:
        world: its file's content, as a dict or as YAML.
        options: of `World.from_file`.
    """
    return WorldFiles().load(world, **options)


def robot(*plugins: Entry, **options: Any) -> Harness:
    """A robot with these plugins in a world of its own; see `WorldFiles.robot`.

    Args:
        plugins: the entries of its plugins.
        options: of `WorldFiles.robot`.
    """
    return WorldFiles().robot(*plugins, **options)


def refusal(*plugins: Entry, **options: Any) -> str:
    """The message with which a robot of these plugins is refused; see `WorldFiles.robot`.

    Args:
        plugins: the entries of its plugins.
        options: of `WorldFiles.robot`.
    """
    return WorldFiles().robot_refusal(*plugins, **options)


def flow(entry: Entry) -> str:
    """A YAML map on one line, in braces."""
    if isinstance(entry, str):
        return entry if entry.lstrip().startswith("{") else f"{{{entry}}}"
    return dump(entry, default_flow_style=True, width=1e9).strip()


def dump(content: Mapping[str, Any], **options: Any) -> str:
    """A map as YAML."""
    return str(yaml.dump(dict(content), Dumper=_DUMPER, sort_keys=False, **options))
