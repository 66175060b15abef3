"""The ways in which a user names a world: a shipped one, a file, or its content as one dict."""

import os
from pathlib import Path
from typing import Any, Dict, Mapping, Optional, Sequence, Union

from flatland_server.arguments import folders_of, params_of, shown
from flatland_server.config import YamlPreprocessor, YamlReader, find_world
from flatland_server.exceptions import UsageError
from flatland_server.maps import TOLERANCES, MapConfig
from flatland_server.models import LayerConfig
from flatland_server.plugins import PluginLoader
from flatland_server.simulation import World, WorldConfig
from flatland_server.transport import LocalTransport, Transport

WorldSource = Union[str, "os.PathLike[str]", Mapping[str, Any], WorldConfig]
"""The name of a shipped world, the path of a world file, the content of one as a dict, or a
`WorldConfig`, which is read once for many simulations of the same world.
"""


def open_world(
    source: WorldSource,
    transport: Transport,
    *,
    seed: int,
    simplify_map: int,
    model_folders: Sequence[Path],
    loader: Optional[PluginLoader],
) -> World:
    """Loads a world.

    Args:
        source: path, shipped name, dict or `WorldConfig` of the world.
        transport: as for `World`.
        seed: as for `World`.
        simplify_map: as for `World.from_file`.
        model_folders: as for `World.from_file`.
        loader: as for `World`.

    Raises:
        FlatlandError: there is no such world, or something in it is wrong.
    """
    if isinstance(simplify_map, bool) or simplify_map not in range(len(TOLERANCES)):
        raise UsageError(f"expected simplify_map to be 0, 1 or 2, found {shown(simplify_map)}")
    if not isinstance(loader, (PluginLoader, type(None))):
        raise UsageError(f"expected a PluginLoader as loader, found {shown(loader)}")
    if isinstance(source, WorldConfig):
        return World(source, transport, seed=seed, loader=loader)
    preprocessor = YamlPreprocessor(transport.get_param, seed)
    found: Any = _found(source)
    read = WorldConfig.from_file if isinstance(found, Path) else WorldConfig.from_content
    config = read(found, preprocessor, simplify_map=simplify_map, model_folders=model_folders)
    return World(config, transport, seed=seed, loader=loader)


def _found(source: Any) -> Union[Path, Mapping[str, Any]]:
    """The file of a world that a user names, or its content.

    Raises:
        FlatlandError: there is no such world.
    """
    if isinstance(source, Mapping):
        return source
    if isinstance(source, (str, os.PathLike)):
        return find_world(source if isinstance(source, str) else Path(source))
    expected = "expected the name of a world, the path of a world file or a dict"
    raise UsageError(f"{expected}, found {shown(source)}")


def world_content(
    world: Union[str, "os.PathLike[str]", Mapping[str, Any]],
    *,
    params: Mapping[str, Any] = {},
    model_folders: Sequence[Union[str, "os.PathLike[str]"]] = (),
) -> Dict[str, Any]:
    """A world as one dict, to be changed and given to `Simulation`.

        content = world_content("office")
        content["models"][0]["pose"] = [2, 0, 0]
        with Simulation(content) as sim: ...

    Includes and expressions are resolved, and models and maps are dicts within it: a map has its
    `segments`, or the `grid` of its image, as an array. Entries with `enabled: false` are left out
    of `models`. Other values are checked when the world is loaded.

    Args:
        world: the name of a shipped world, the path of a world file, or the content of one.
        params: parameters by absolute name, for expressions in the files.
        model_folders: where model files are looked up that are not beside the world file.

    Returns:
        A new dict of lists, dicts, strings, numbers, booleans and arrays.

    Raises:
        FlatlandError: there is no such world, or a file is missing or no YAML.
    """
    return content_with(LocalTransport(params_of(params), ()), world, folders_of(model_folders))


def content_with(
    transport: LocalTransport,
    world: Union[str, "os.PathLike[str]", Mapping[str, Any]],
    folders: Sequence[Path] = (),
) -> Dict[str, Any]:
    """As `world_content`.

    Args:
        transport: has the parameters, and marks those that expressions read.
        world: as for `world_content`.
        folders: folders to look for models in.
    """
    preprocessor = YamlPreprocessor(transport.get_param)
    absolute = [folder.absolute() for folder in folders]
    content = read_world_content(world, preprocessor, absolute)
    for layer in content.get("layers") or ():
        if isinstance(layer.get("map"), str):
            layer["map"] = MapConfig.from_file(Path(layer["map"]), preprocessor).content()
    return content


def read_world_content(
    world: Union[str, "os.PathLike[str]", Mapping[str, Any]],
    preprocessor: YamlPreprocessor,
    folders: Sequence[Path] = (),
) -> Dict[str, Any]:
    """Like `world_content`, but with the absolute paths of maps in files.

    So are those of `file` in the maps of a plugin, such as a Crowd's `recording`.

    Args:
        world: as for `world_content`.
        preprocessor: evaluates expressions, with their parameters.
        folders: where model files are looked up that are not beside the world file.

    Raises:
        FlatlandError: as `world_content`.
    """
    found = _found(world)
    if isinstance(found, Path):
        reader = YamlReader.from_file(found, preprocessor)
    else:
        reader = YamlReader.from_content(found, "world", preprocessor)

    def model(section: YamlReader) -> Optional[Dict[str, Any]]:
        return _model_entry(section, preprocessor, folders)

    content = reader.content()
    files = reader.get_sections("plugins", _files)
    maps = reader.get_sections("layers", LayerConfig.read_map_source)
    models = reader.get_sections("models", model)
    reader.raise_problems()
    for layer, path in zip(content.get("layers") or (), maps):
        if isinstance(path, Path):
            layer["map"] = os.path.abspath(path)
    for plugin, paths in zip(content.get("plugins") or (), files):
        for key, path in paths.items():
            plugin[key]["file"] = path
    content["models"] = [entry for entry in models if entry is not None]
    return content


def _files(section: YamlReader) -> Dict[str, str]:
    """The absolute paths of the files that maps of a plugin's entry name, by the maps' keys."""
    found: Dict[str, str] = {}
    if section.get_bool("enabled", True):
        for key, value in section.content().items():
            if isinstance(value, dict) and isinstance(value.get("file"), str):
                found[key] = os.path.abspath(section.get_section(key).get_path("file"))
    return found


def _model_entry(
    section: YamlReader, preprocessor: YamlPreprocessor, folders: Sequence[Path]
) -> Optional[Dict[str, Any]]:
    """An entry of `models`, its model a dict; None if it is switched off."""
    if not section.get_bool("enabled", True):
        return None
    entry = section.content()
    if not section.is_map("model"):
        path = section.get_path("model", folders)
        section.raise_problems()
        entry["model"] = YamlReader.from_file(path, preprocessor).content()
    return entry
