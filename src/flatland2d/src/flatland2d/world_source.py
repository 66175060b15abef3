"""The ways in which a user names a world: a shipped one, a file, or its content."""

import os
from pathlib import Path
from typing import Any, Mapping, Optional, Sequence, Union

from flatland_server.arguments import shown
from flatland_server.config import YamlPreprocessor, find_world
from flatland_server.exceptions import UsageError
from flatland_server.maps import TOLERANCES
from flatland_server.plugins import PluginLoader
from flatland_server.simulation import World, WorldConfig
from flatland_server.transport import Transport

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
    read: Any = WorldConfig.from_file
    content: Any = source
    if isinstance(source, Mapping):
        read = WorldConfig.from_content
    elif isinstance(source, (str, os.PathLike)):
        content = find_world(source if isinstance(source, str) else Path(source))
    else:
        raise UsageError(
            "expected the name of a world, the path of a world file or a dict, "
            f"found {shown(source)}"
        )
    config = read(content, preprocessor, simplify_map=simplify_map, model_folders=model_folders)
    return World(config, transport, seed=seed, loader=loader)
