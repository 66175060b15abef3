"""Checks world and model files without a ROS master: rosrun flatland_server check_world FILE..."""

import argparse
import logging
import sys
from pathlib import Path
from typing import List, Optional, Sequence

from flatland_server.config.file_names import to_path
from flatland_server.config.yaml_preprocessor import YamlPreprocessor
from flatland_server.config.yaml_reader import YamlReader
from flatland_server.exceptions import FlatlandError, YamlError
from flatland_server.geometry import Pose
from flatland_server.models.collision_filter_registry import AnyLayer
from flatland_server.models.model import ModelConfig
from flatland_server.simulation.world import World
from flatland_server.simulation.world_config import ModelEntry, WorldConfig
from flatland_server.tools.render import render


def load(path: Path, preprocessor: YamlPreprocessor, model_folders: Sequence[Path] = ()) -> World:
    """Loads a world file; or a model file, into an otherwise empty world.

    Args:
        path: of the file; one with a key `bodies` is a model file.
        preprocessor: for its expressions.
        model_folders: where models are looked up that are not beside the world file.

    Raises:
        FlatlandError: something in the files is wrong.
    """
    reader = YamlReader.from_file(path, preprocessor)
    if not reader.has("bodies"):
        return World(WorldConfig.read(reader, preprocessor, model_folders=model_folders))
    registry = AnyLayer()
    model = ModelConfig.read(reader, registry)
    entry = ModelEntry(path.name.split(".")[0], "", Pose(), model)
    return World(WorldConfig(10, 10, registry, (), (entry,), ()))


def summary(world: World) -> str:
    """The numbers of layers, models and other parts of a world, in a line."""
    models = world.models.values()
    counts = (
        (len(world.layers), "layer"),
        (sum(len(layer.segments) for layer in world.layers), "segment"),
        (len(models), "model"),
        (sum(len(model.bodies) for model in models), "body"),
        (world.plugin_count, "plugin"),
    )
    plurals = {"body": "bodies"}
    return ", ".join(
        f"{count} {noun if count == 1 else plurals.get(noun, noun + 's')}" for count, noun in counts
    )


def check(name: str, picture: Optional[Path], model_folders: Sequence[Path] = ()) -> List[str]:
    """Checks a file, and prints a summary if it is valid.

    Args:
        name: of a world or model file: its path, or a `package://` URI.
        picture: the image file to draw the world into, if any.
        model_folders: where models are looked up that are not beside the world file.

    Returns:
        The problems, a line for each; empty if there are none.
    """
    preprocessor = YamlPreprocessor()
    path = Path(name)
    try:
        path = to_path(name)
        world = load(path, preprocessor, model_folders)
    except YamlError as error:
        return error.lines(lambda problem: problem.with_column)
    except FlatlandError as error:
        return [f"{path}: {error}"]
    finally:
        preprocessor.close()
    print(f"{path}: {summary(world)}")
    problems = []
    if picture is not None:
        try:
            render(world).save(picture)
        except (OSError, ValueError) as error:  # ValueError: an unknown file extension
            problems = [f"{picture}: cannot be written: {error}"]
    world.close()
    return problems


def main(arguments: Optional[List[str]] = None) -> int:
    """Runs the command.

    Args:
        arguments: of the command line; by default those of the process.

    Returns:
        The exit code: 0 if all files are valid, else 1.
    """
    parser = argparse.ArgumentParser(
        prog="check_world", description="Check Flatland world and model files."
    )
    parser.add_argument("files", nargs="+", metavar="FILE", help="world or model file")
    parser.add_argument(
        "--render", type=Path, metavar="PNG", help="draw the world as it would look at the start"
    )
    parser.add_argument(
        "--models",
        type=Path,
        action="append",
        default=[],
        metavar="FOLDER",
        help="as the server's ~models: look up models there that are not beside the world file",
    )
    options = parser.parse_args(arguments)
    if options.render is not None and len(options.files) > 1:
        parser.error("--render takes a single FILE")
    logging.basicConfig(format="%(message)s", level=logging.INFO)
    problems: List[str] = []
    for name in options.files:
        problems += check(name, options.render, options.models)
    for problem in problems:
        print(problem, file=sys.stderr)
    return 1 if problems else 0
