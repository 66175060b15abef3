"""Fingerprints of scenarios: equal ones have equal results, which are computed once.

A fingerprint covers the scenario file and the contents of the files that it names: worlds, models,
maps, recorded people, the file of the controller, the policy. Modules that it imports are
not covered, nor are plugins.
"""

import hashlib
import importlib.util
import json
import os
from itertools import product
from pathlib import Path
from typing import Any, Dict, List, Mapping, Set, Tuple

from flatland2d.simulation import Simulation
from flatland2d.sweep.controllers import arguments_of, find_controller, policy_file, python_file
from flatland2d.sweep.parameters import (
    SweepWorlds,
    is_for_controller,
    world_file,
    world_key,
    world_params,
)
from flatland2d.sweep.settings import Controller, Scenario, SweepSettings
from flatland_server.config import MAX_IMAGE, YamlPreprocessor, read_input
from flatland_server.maps import MapConfig

_LENGTH = 16


class Fingerprints:
    """Computes the fingerprints of a sweep's scenarios, and so checks its worlds and controllers.

    Attributes:
        unused: the parameters that change nothing: no file reads them, and no controller takes
            them.

    Raises:
        FlatlandError: a world or a controller cannot be used.
    """

    def __init__(self, settings: SweepSettings) -> None:
        general = {
            name: getattr(settings, name)
            for name in ("step_size", "control_period", "time_limit", "collision_ends")
        }
        self._general = _digest(general)
        self._settings = settings
        self._files: Dict[Path, str] = {}
        self._params_read: Set[str] = set()
        first = settings.parameters[0]
        for world in settings.worlds:
            file = world_file(world.source, settings.folder)
            with Simulation(file, params=world_params(first)) as simulation:
                # Loads the original files, so that errors name their lines.
                self._params_read |= simulation.transport.params_read
        self._worlds = self._fingerprints_of_worlds()
        self._controllers = {
            each.name: _controller(each, settings.folder, first) for each in settings.controllers
        }
        self.unused = self._unused()

    def of(self, scenario: Scenario) -> str:
        """The fingerprint of a scenario: 16 hexadecimal digits."""
        parts = [
            self._general,
            self._worlds[world_key(scenario.world.name, scenario.parameters)],
            self._controllers[scenario.controller.name],
            dict(scenario.parameters),
            scenario.seed,
        ]
        return _digest(parts)

    def _fingerprints_of_worlds(self) -> Dict[str, str]:
        """The fingerprints of worlds with models and maps, for each combination of parameters."""
        found: Dict[str, str] = {}
        worlds = SweepWorlds(self._settings.folder)
        for world, parameters in product(self._settings.worlds, self._settings.parameters):
            key = world_key(world.name, parameters)
            if key not in found:
                content = worlds.content(world.source, parameters)
                maps = self._maps(content, worlds.preprocessor)
                maps.update(self._files_of_plugins(content))
                found[key] = _digest([content, maps, dict(vars(world.task))])
        self._params_read |= worlds.params_read
        return found

    def _unused(self) -> List[str]:
        """The parameters that change nothing."""
        is_driven = any(each.target for each in self._settings.controllers)
        combined: Dict[str, Any] = {}
        for parameters in self._settings.parameters:
            combined.update(parameters)
        arguments = [] if is_driven else [n for n in combined if is_for_controller(n)]
        return [n for n in world_params(combined) if n not in self._params_read] + arguments

    def _maps(self, content: Dict[str, Any], preprocessor: YamlPreprocessor) -> Dict[str, str]:
        """The fingerprints of map files; in the content, only the names of their paths remain."""
        maps: Dict[str, str] = {}
        for layer in content.get("layers") or ():
            if isinstance(layer.get("map"), str) and layer["map"]:
                path = Path(layer["map"])
                config = MapConfig.from_file(path, preprocessor)
                maps.update(map(self._named, filter(None, (path, config.source))))
                layer["map"] = path.name
        return maps

    def _files_of_plugins(self, content: Dict[str, Any]) -> Dict[str, str]:
        """The same of files that maps of the world's plugins name, as a Crowd's `recording`."""
        files: Dict[str, str] = {}
        for plugin in content.get("plugins") or ():
            for value in plugin.values():
                if isinstance(value, dict) and os.path.isabs(value.get("file") or ""):
                    files.update([self._named(Path(value["file"]))])
                    value["file"] = Path(value["file"]).name
        return files

    def _named(self, file: Path) -> Tuple[str, str]:
        """The name of a file, and its fingerprint."""
        if file not in self._files:
            self._files[file] = _file(file)
        return file.name, self._files[file]


def _controller(controller: Controller, folder: Path, parameters: Mapping[str, Any]) -> str:
    """The fingerprint of a controller's function, with its file."""
    function = find_controller(controller, folder)
    arguments_of(controller, function, parameters, folder)
    parts = [controller.target, dict(controller.arguments)]
    file = python_file(controller.target, folder)
    if file is None and controller.target:
        spec = importlib.util.find_spec(controller.target.rpartition(":")[0])
        file = Path(spec.origin) if spec is not None and spec.origin else None
    if file is not None:
        parts.append(_file(file))
    if controller.policy:
        parts.append(_file(policy_file(controller, folder)))
    return _digest(parts)


def _file(path: Path) -> str:
    return hashlib.sha256(read_input(path, MAX_IMAGE)).hexdigest()


def _digest(content: Any) -> str:
    text = json.dumps(content, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:_LENGTH]
