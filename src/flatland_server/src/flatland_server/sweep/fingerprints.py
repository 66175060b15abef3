"""Fingerprints of scenarios: equal ones have equal results, which are computed once.

A fingerprint covers what the scenario file says and what the files contain that it names: worlds,
models and maps, the controller's file and the policy. Modules that a controller imports are not
covered, nor are plugins.
"""

import hashlib
import importlib.util
import json
from contextlib import closing
from pathlib import Path
from typing import Any, Dict, Mapping

from flatland_server.config.input_files import MAX_IMAGE, read_input
from flatland_server.config.yaml_preprocessor import YamlPreprocessor
from flatland_server.library.simulation import Simulation
from flatland_server.library.world_content import world_content
from flatland_server.maps.map_reader import MapConfig
from flatland_server.sweep.controllers import (
    arguments_of,
    find_controller,
    policy_file,
    python_file,
)
from flatland_server.sweep.parameters import set_value, world_changes, world_params
from flatland_server.sweep.scenario import Scenario
from flatland_server.sweep.scenario_file import world_source
from flatland_server.sweep.settings import Controller, SweepSettings, SweepWorld

_LENGTH = 16


class Fingerprints:
    """Computes the fingerprints of a sweep's scenarios, and so checks what it consists of.

    Args:
        settings: of the sweep.

    Raises:
        FlatlandError: a world or a controller cannot be used.
    """

    def __init__(self, settings: SweepSettings) -> None:
        general = {
            name: getattr(settings, name)
            for name in ("step_size", "control_period", "time_limit", "collision_ends")
        }
        self._general = _digest(general)
        first = settings.parameters[0]
        self._worlds = {world.name: _world(settings, world) for world in settings.worlds}
        self._controllers = {
            each.name: _controller(each, settings.folder, first) for each in settings.controllers
        }

    def of(self, scenario: Scenario) -> str:
        """The fingerprint of a scenario: 16 hexadecimal digits."""
        parts = [
            self._general,
            self._worlds[scenario.world.name],
            self._controllers[scenario.controller.name],
            dict(scenario.parameters),
            scenario.seed,
        ]
        return _digest(parts)


def _world(settings: SweepSettings, world: SweepWorld) -> str:
    """Of a world with its models and maps, as the first combination of parameters has it."""
    params = world_params(settings.parameters[0])
    source = world_source(world.source, settings.folder)
    with Simulation(source, params=params):
        pass  # names what is wrong by its place in the files
    content = world_content(source, params=params)
    maps: Dict[str, str] = {}
    with closing(YamlPreprocessor()) as preprocessor:
        for layer in content.get("layers") or ():
            if layer.get("map"):
                path = Path(layer["map"])
                config = MapConfig.from_file(path, preprocessor)
                for file in (path, config.source):
                    maps[file.name] = _file(file)
                layer["map"] = path.name  # the same in another folder
    fingerprint = _digest([content, maps, dict(vars(world.task))])
    for parameters in settings.parameters:
        for place, value in world_changes(parameters).items():
            set_value(content, place, value)  # raises if there is no such place
    return fingerprint


def _controller(controller: Controller, folder: Path, parameters: Mapping[str, Any]) -> str:
    """Of a controller's function, with its file."""
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
