"""Former names, which go on working with a DeprecationWarning that tells the new one."""

import importlib
import sys
import warnings
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import CodeType, ModuleType
from typing import Any, Optional, Sequence, Set, Tuple

_MOVED = {
    "check_world": "tools.check_world",
    "collision_filter_registry": "models.collision_filter_registry",
    "contact": "_core",
    "contact_dispatcher": "plugins.contact_dispatcher",
    "entity": "models.entity",
    "footprint": "models.footprint",
    "joint": "models.joint",
    "layer": "models.layer",
    "local_transport": "transport.local_transport",
    "message_writer": "transport.message_writer",
    "model": "models.model",
    "model_body": "models.model_body",
    "model_plugin": "plugins.model_plugin",
    "names": "config.ros_names",
    "node": "transport.node",
    "plugin": "plugins.plugin",
    "plugin_config": "models.plugin_config",
    "plugin_loader": "plugins.plugin_loader",
    "plugin_manager": "plugins.plugin_manager",
    "render": "tools.render",
    "simplify_outlines": "maps.simplify_outlines",
    "simulation_manager": "simulation.simulation_manager",
    "wall_outlines": "maps.wall_outlines",
    "world": "simulation.world",
    "world_config": "simulation.world_config",
    "world_plugin": "simulation.world",
    "yaml_preprocessor": "config.yaml_preprocessor",
    "yaml_reader": "config.yaml_reader",
    "yaml_values": "config.yaml_values",
}
"""Modules by their former name, both within `flatland_server`."""


class FormerNameWarning(DeprecationWarning):
    """A former name of `flatland_server` is in use. Python hides it, `PluginLoader` logs it."""


def warn_renamed(old: str, new: str, stacklevel: int = 3) -> None:
    """Warns that a name is deprecated, at the line that uses it.

    Args:
        old: the name in use.
        new: what to write instead.
        stacklevel: of `warnings.warn`; 3 is the caller of the function that calls this one.
    """
    warnings.warn(f"{old} is deprecated; use {new}", FormerNameWarning, stacklevel)


def renamed(old: str, new: str) -> Any:
    """A class attribute `old` that reads, as a deprecated alias, the attribute `new`.

    It warns once for each line of code: the line may be in a hook that is called at every step.
    """
    warned: Set[Tuple[CodeType, int]] = set()

    def get(self: object) -> Any:
        user = sys._getframe(1)
        line = (user.f_code, user.f_lineno)
        if line not in warned:
            warned.add(line)
            warn_renamed(f"{type(self).__name__}.{old}", new)
        return getattr(self, new)

    return property(get, doc=f"Deprecated alias of `{new}`.")


class _MovedModuleFinder(MetaPathFinder, Loader):
    """Imports a module by its former name: an empty module that forwards to the new one.

    It warns at each use, and not only when it is made: there may be several modules to correct.
    """

    def __init__(self, package: str) -> None:
        self._package = package

    def find_spec(
        self, name: str, path: Optional[Sequence[str]] = None, target: Optional[ModuleType] = None
    ) -> Optional[ModuleSpec]:
        package, _, module = name.rpartition(".")
        if package != self._package or module not in _MOVED:
            return None
        return ModuleSpec(name, self)

    def exec_module(self, module: ModuleType) -> None:
        name = module.__name__.rpartition(".")[2]
        new = importlib.import_module(f"{self._package}.{_MOVED[name]}")
        message = (
            f"the module {module.__name__} has moved: import from {self._package}, "
            f"or from {new.__name__} what that does not export"
        )

        def get(attribute: str) -> Any:
            value = getattr(new, attribute)
            warnings.warn(message, FormerNameWarning, stacklevel=2)
            return value

        vars(module)["__getattr__"] = get
        vars(module)["__dir__"] = lambda: dir(new)


def install_moved_modules(package: str) -> None:
    """Makes the former names of the modules of `package` importable."""
    if not any(isinstance(finder, _MovedModuleFinder) for finder in sys.meta_path):
        sys.meta_path.append(_MovedModuleFinder(package))
