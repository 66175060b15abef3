"""flatland check: reports all that is wrong in files.

A file is a world, a model or a map: its keys tell which.
"""

import argparse
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any, Dict, List, Optional, Sequence, Tuple

import numpy as np

from flatland2d.cli.arguments import Subparsers, add_sources
from flatland2d.rendering.renderer import Renderer, save
from flatland_server.config import YamlPreprocessor, YamlReader, shipped_worlds, to_path
from flatland_server.exceptions import FlatlandError, Problem, YamlError, counted
from flatland_server.geometry import Pose
from flatland_server.maps import MapConfig
from flatland_server.models import (
    AnyLayer,
    BodyConfig,
    CollisionFilterRegistry,
    JointConfig,
    LayerConfig,
    ModelConfig,
    PluginConfig,
)
from flatland_server.simulation import ModelEntry, World, WorldConfig
from flatland_server.transport import LocalTransport, Transport

_MAP_NAME = "map"
"""The name of the layer in which a map alone is shown."""

_MAP_COLOR = (0.4, 0.4, 0.4, 1.0)

_MODEL_KEYS = ("bodies",)
_WORLD_KEYS = ("properties", "layers", "models")
_MAP_KEYS = ("image", "data", "resolution", "scale", "origin", "occupied_thresh")


def load(
    path: Path,
    preprocessor: YamlPreprocessor,
    model_folders: Sequence[Path] = (),
    transport: Optional[Transport] = None,
) -> Tuple[World, str]:
    """Loads a world file; or a model or map file, into an otherwise empty world.

    Args:
        path: path of a world, model or map file.
        preprocessor: evaluates the expressions in the file.
        model_folders: where models are looked up that are not beside the world file.
        transport: for the plugins; by default one without parameters.

    Returns:
        The world that the file makes, and a line about it.

    Raises:
        FlatlandError: something in the files is wrong, or the file is none of these.
    """
    reader = YamlReader.from_file(path, preprocessor)
    if any(map(reader.has, _MODEL_KEYS)):
        return _load_model(path, reader, transport)
    if any(map(reader.has, _WORLD_KEYS)):
        config = WorldConfig.read(reader, preprocessor, model_folders=model_folders)
        world = World(config, transport)
        return world, _contents(world)
    if any(map(reader.has, _MAP_KEYS)):
        return _load_map(path, preprocessor)
    raise reader.error(
        'expected a world, which has the keys "properties" and "layers", a model ("bodies"), or a '
        'map ("image" or "data", "resolution" or "scale", "origin"); found none of these keys'
    )


def _load_model(
    path: Path, reader: YamlReader, transport: Optional[Transport]
) -> Tuple[World, str]:
    registry = AnyLayer()
    model = ModelConfig.read(reader, registry)
    entry = ModelEntry(path.name.split(".")[0], "", Pose(), model)
    world = World(WorldConfig(10, 10, registry, (), (entry,), ()), transport)
    return world, _contents(world)


def _load_map(path: Path, preprocessor: YamlPreprocessor) -> Tuple[World, str]:
    segments = MapConfig.from_file(path, preprocessor).walls()
    registry = CollisionFilterRegistry()
    layer = LayerConfig((_MAP_NAME,), registry.register(_MAP_NAME), _MAP_COLOR, 0.0, 1.0, path)
    world = World(WorldConfig(10, 10, registry, (layer,), (), (), {path: segments}))
    corners = segments.reshape(-1, 2)
    width, height = np.ptp(corners, axis=0) if len(corners) else (0.0, 0.0)
    size = f"{width:.4g} x {height:.4g} m"
    return world, f"a map of {counted(len(segments), 'segment')}, {size}"


def _contents(world: World) -> str:
    """The numbers of layers, models and other parts of a world."""
    models = world.models.values()
    bodies = sum(len(model.bodies) for model in models)
    counts = (
        counted(len(world.layers), "layer"),
        counted(sum(len(layer.segments) for layer in world.layers), "segment"),
        counted(len(models), "model"),
        "1 body" if bodies == 1 else f"{bodies} bodies",
        counted(world.plugin_count, "plugin"),
    )
    return ", ".join(counts)


def check(
    name: str,
    picture: Optional[Path],
    model_folders: Sequence[Path] = (),
    params: Dict[str, Any] = {},  # noqa: B006 (only read)
) -> List[str]:
    """Checks a file, and prints a summary if it is valid.

    Args:
        name: of a world, model or map file: its path, or a `package://` URI.
        picture: image file for a picture of the world; none: no picture.
        model_folders: where models are looked up that are not beside the world file.
        params: parameters by name, for expressions and plugins.

    Returns:
        The problems, a line for each; empty if there are none.
    """
    transport = LocalTransport(params)
    preprocessor = YamlPreprocessor(transport.get_param)
    path = Path(name)
    try:
        path = to_path(name)
        world, summary = load(path, preprocessor, model_folders, transport)
    except YamlError as error:
        others = plugin_problems(path, preprocessor, model_folders, transport)
        every = YamlError.of([*error.problems, *others])
        return every.lines(lambda problem: problem.with_column)
    except FlatlandError as error:
        return [f"{path}: {error}"]
    print(f"{path}: {summary}")
    problems = []
    if picture is not None:
        try:
            save(picture, Renderer(world), names=True)
        except FlatlandError as error:
            problems = [str(error)]
    world.close()
    return problems


def add_parser(commands: Subparsers) -> None:
    """Adds the subcommand."""
    description = (
        "Check world, model and map files. All that is wrong is reported at once, as "
        "file:line:column: message."
    )
    parser = commands.add_parser("check", help="check files", description=description)
    parser.add_argument("files", nargs="+", metavar="FILE", help="world, model or map file")
    parser.add_argument(
        "--render",
        type=Path,
        metavar="FILE",
        help="draw the world as it would look at the start, into a .png, .svg ...",
    )
    add_sources(parser)
    parser.set_defaults(execute=_execute, parser=parser)


def _execute(options: argparse.Namespace) -> int:
    if options.render is not None and len(options.files) > 1:
        options.parser.error("--render takes a single FILE")
    worlds = shipped_worlds()
    problems: List[str] = []
    for name in options.files:
        file = str(worlds.get(name, name))
        problems += check(file, options.render, options.models, dict(options.params))
    for problem in problems:
        print(problem, file=sys.stderr)
    return 1 if problems else 0


def plugin_problems(
    path: Path, preprocessor: YamlPreprocessor, model_folders: Sequence[Path], transport: Transport
) -> List[Problem]:
    """The problems of the plugins of a model, or of all models of a world.

    Args:
        path: of the world or model file.
        preprocessor: evaluates the expressions in the file.
        model_folders: where models are looked up that are not beside the world file.
        transport: carries the topics and parameters of the plugins.
    """
    problems: List[Problem] = []
    with suppress(FlatlandError):
        reader = YamlReader.from_file(path, preprocessor)
        if reader.has("bodies"):
            return _problems_of_model(reader, transport)
        files: Dict[Path, None] = {}

        def read_entry(entry: YamlReader) -> None:
            if entry.is_map("model"):
                problems.extend(_problems_of_model(entry.get_section("model"), transport))
            else:
                files[entry.get_path("model", model_folders)] = None

        reader.get_sections("models", read_entry)
        for file in files:
            with suppress(FlatlandError):
                problems += _problems_of_model(YamlReader.from_file(file, preprocessor), transport)
    return problems


def _problems_of_model(reader: YamlReader, transport: Transport) -> List[Problem]:
    registry = AnyLayer()
    faulty_joints: List[str] = []

    def read_body(section: YamlReader) -> BodyConfig:
        name = section.get_string("name")
        try:
            return BodyConfig.read(section, registry)
        except YamlError:
            return BodyConfig(name, Pose(), "dynamic", (1.0, 1.0, 1.0, 1.0), 0.0, 0.0, ())

    bodies = reader.get_enabled_sections("bodies", read_body)
    names = [body.name for body in bodies]
    if not bodies or not all(names):
        return []  # plugins name bodies that are missing

    def read_joint(section: YamlReader) -> JointConfig:
        try:
            return JointConfig.read(section, names)
        except YamlError:
            faulty_joints.append(section.get_string("name"))
            raise

    joints = reader.get_enabled_sections("joints", read_joint)
    plugins = [
        each
        for each in reader.get_enabled_sections("plugins", PluginConfig.read)
        if not any(map(each.reader.key_of, faulty_joints))  # it needs one of them
    ]
    model = ModelConfig(reader.file, tuple(bodies), tuple(joints), tuple(plugins), is_read=True)
    entry = ModelEntry(reader.file.name.split(".")[0], "", Pose(), model)
    try:
        World(WorldConfig(10, 10, registry, (), (entry,), ()), transport).close()
    except YamlError as error:
        return list(error.problems)
    except FlatlandError:  # the bodies do not make a model
        return []
    return []
