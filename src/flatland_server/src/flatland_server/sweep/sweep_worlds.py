"""The worlds of a sweep, with what the parameters of a scenario change in them.

The process that evaluates expressions is kept: starting one takes longer than reading most worlds.
"""

from copy import deepcopy
from pathlib import Path
from typing import Any, Dict, Mapping, Optional, Set, Tuple, Union

from flatland_server.config.file_names import to_path
from flatland_server.config.yaml_preprocessor import YamlPreprocessor
from flatland_server.library.world_content import read_world_content
from flatland_server.sweep.parameters import names_a_file, set_value, world_changes, world_params
from flatland_server.sweep.scenario_file import world_source
from flatland_server.transport.local_transport import absolute_name

_Read = Tuple[str, Dict[str, Any], Dict[str, Any]]
"""A world's name in the scenario file, the parameters that its files have read, its content."""


class SweepWorlds:
    """Reads worlds, each as one dict with its models.

    Args:
        folder: of the scenario file, to which paths are relative.

    Attributes:
        preprocessor: of the world that was read last, with its parameters.
        params_read: the parameters that expressions in the files have read so far, by name.
    """

    def __init__(self, folder: Path) -> None:
        self.preprocessor = YamlPreprocessor(self._get_param)
        self.params_read: Set[str] = set()
        self._folder = folder
        self._params: Mapping[str, Any] = {}
        self._reading: Dict[str, Any] = {}
        self._last: Optional[_Read] = None

    def content(self, source: str, parameters: Mapping[str, Any]) -> Dict[str, Any]:
        """A world as the parameters of a scenario have it: a new dict.

        Args:
            source: as it is written in the scenario file.
            parameters: of a scenario.

        Raises:
            FlatlandError: something in its files is wrong, or a parameter has no place in it.
        """
        self._params = world_params(parameters)
        content = self._content_of(source)
        changes = world_changes(parameters)
        for place, value in changes.items():
            if names_a_file(place) and isinstance(value, str):
                value = str(self._folder / to_path(value))
            set_value(content, place, value)
        if any(map(names_a_file, changes)):
            content = self._read(content)  # again, with the files that have been put in
        return content

    def close(self) -> None:
        """Ends the process that evaluates expressions."""
        self.preprocessor.close()

    def _content_of(self, source: str) -> Dict[str, Any]:
        """The content of a world's files; read again only if they read other parameters."""
        if self._last is not None and self._last[0] == source:
            _, read, content = self._last
            if all(self._params.get(name) == value for name, value in read.items()):
                return deepcopy(content)
        self._reading = {}
        content = self._read(world_source(source, self._folder))
        self._last = source, self._reading, content
        return deepcopy(content)

    def _read(self, world: Union[str, Path, Mapping[str, Any]]) -> Dict[str, Any]:
        """Reads a world from its files."""
        self.preprocessor.restart_random()
        return read_world_content(world, self.preprocessor)

    def _get_param(self, name: str, default: Any) -> Any:
        name = absolute_name(name)
        self.params_read.add(name)
        self._reading[name] = self._params.get(name)
        return self._params.get(name, default)
