"""Finds plugins by their type, as pluginlib does, and makes them.

A C++ class, with `::` in its `type` in the XML file, cannot be loaded: only a file that names it
gets an error. Plugins of `EXAMPLE_PACKAGE`, which is there to be copied, are hidden by others of
the same name.
"""

import importlib
import inspect
import logging
import os
import sys
from functools import lru_cache
from typing import Any, Callable, Dict, Iterable, Optional, Type, TypeVar

import numpy as np

from flatland_server.exceptions import (
    PLUGIN_ERRORS,
    FlatlandError,
    PluginError,
    TopicError,
    YamlError,
    shortened,
    suggestion,
)
from flatland_server.models.plugin_config import PluginConfig
from flatland_server.plugins.declarations import PluginDeclaration, discover
from flatland_server.plugins.plugin import Plugin
from flatland_server.transport.node import Node

__all__ = ["EXAMPLE_PACKAGE", "PluginDeclaration", "PluginLoader", "discover", "shared_loader"]

logger = logging.getLogger(__name__)

P = TypeVar("P", bound=Plugin)

EXAMPLE_PACKAGE = "flatland_example_plugins"
"""The package that users copy under another name: a copy hides the plugins of the original."""

_BUILT_IN = "flatland_plugins"

ALIASES = {"PedsimMovement": "Pedestrian", "PosePub": "PosePublisher"}
"""Types in files of other simulators, and the built-in plugins that are meant, unless a package
declares a Python class of that name."""


_CPP_PLUGINS = {
    "ackermannDrive": "",
    "RandomGates": "",
    "RandomWandering": "a Crowd whose pedestrians have several goals",
    "StaticLaser": "a Laser with the map's layers",
    "VehicleMovement": "a Pedestrian in a model without legs",
}
"""C++ plugins of public packages for the original Flatland, which may not be on the path, and what
docs/coming_from_cpp.md tells to use for them."""


class PluginLoader:
    """Imports plugins on demand.

    Args:
        declarations: the available plugins; by default those that packages declare, which are
            looked up when the first plugin is needed.
    """

    def __init__(self, declarations: Optional[Iterable[PluginDeclaration]] = None) -> None:
        self._declarations = None if declarations is None else list(declarations)
        self._found: Dict[str, PluginDeclaration] = {}

    def load(self, type: str, base: Type[P]) -> Type[P]:
        """The class of a type in a YAML file.

        Args:
            type: such as `Laser` or `flatland_plugins::Laser`.
            base: the class must derive from it: `ModelPlugin` or `WorldPlugin`.

        Raises:
            PluginError: there is no such plugin or more than one, it cannot be imported, or it is
                not derived from `base`.
        """
        declaration = self._found.get(type)
        if declaration is None:
            declaration = self._found[type] = self._find(type)
        cls = _import(declaration)
        if not (inspect.isclass(cls) and issubclass(cls, base)):
            raise PluginError(f'"{type}" is not a {base.__name__}: {declaration.class_path}')
        return cls

    def make(
        self,
        config: PluginConfig,
        base: Type[P],
        subject: Any,
        node: Node,
        rng: np.random.Generator,
        on_failure: Callable[[P, str], None],
    ) -> P:
        """Makes a plugin and initializes it.

        Args:
            config: the plugin's entry in the file of a model or of the world.
            base: base class that the plugin must have.
            subject: the model, or the world, that the plugin belongs to.
            node: the plugin's node.
            rng: the plugin's random numbers.
            on_failure: called with the plugin and a description of the callback, if a callback of
                one of its subscriptions raises an exception.

        Raises:
            FlatlandError: there is no such plugin, or it does not start. It leaves no topics.
        """
        reader = config.reader
        try:
            plugin_class = self.load(config.type, base)
        except PluginError as error:
            raise reader.error(str(error), "type") from error.__cause__
        node.warn = reader.warn
        try:
            plugin = plugin_class(config.type, config.name, node, rng, subject)  # type: ignore[call-arg]
            node.on_failure = lambda where: on_failure(plugin, where)
            if plugin.accept_other_keys:
                reader.accept_other_keys()
            plugin.on_initialize(reader)
            reader.finish()
        except BaseException as error:
            node.close()
            if isinstance(error, YamlError) or not isinstance(error, PLUGIN_ERRORS):
                raise
            reader.raise_problems()  # a placeholder for a wrong value may have made it fail
            reason = str(error)
            if not isinstance(error, FlatlandError):
                reason = f"does not start: {type(error).__name__}: {error}"
            key = reader.key_of(error.name) if isinstance(error, TopicError) else None
            raise reader.error(reason, key) from error
        return plugin

    def _find(self, type: str) -> PluginDeclaration:
        if self._declarations is None:
            self._declarations = discover()
        answering = [d for d in self._declarations if d.answers_to(type)]
        found = [d for d in answering if not d.is_cpp]
        package, separator, name = type.rpartition("::")
        if not found and name in ALIASES:
            alias = f"{package}{separator}{ALIASES[name]}"
            built_in = [d for d in self._declarations if d.package == _BUILT_IN]
            found = [d for d in built_in if d.answers_to(alias)]
        if answering and not found:
            cpp = answering[0]
            raise PluginError(_cpp_error(type, f"of the package {cpp.package} ({cpp.class_path})"))
        if not found and name in _CPP_PLUGINS:
            text = _cpp_error(type, "of other packages for the original Flatland")
            replacement = _CPP_PLUGINS[name] and f", or use {_CPP_PLUGINS[name]}"
            raise PluginError(text + replacement)
        if not found:
            names = sorted(d.name for d in self._declarations if not d.is_cpp)
            known = ", ".join(names) or f"none; {_question()}"
            hint = suggestion(name, names)
            raise PluginError(f'unknown plugin type "{shortened(type)}"{hint}; there are: {known}')
        found = list({d.class_path: d for d in found}.values())
        if len(found) > 1:
            found = [d for d in found if d.package != EXAMPLE_PACKAGE] or found
        if len(found) > 1:
            choices = " or ".join(f"{d.namespace or d.package}::{d.name}" for d in found)
            raise PluginError(f'the plugin type "{type}" is ambiguous: write {choices}')
        return found[0]


@lru_cache(maxsize=1)
def shared_loader() -> PluginLoader:
    """Finds the plugins that packages export, looked up once in a process."""
    return PluginLoader()


def _question() -> str:
    """A question to users without any plugins, not even the built-in ones."""
    if "ROS_PACKAGE_PATH" in os.environ:
        return "is the workspace's setup.bash sourced?"
    return "is flatland2d installed in this Python (pip install)?"


def _cpp_error(type: str, origin: str) -> str:
    return (
        f'"{type}" is a C++ plugin {origin}; this Flatland runs plugins written in Python: '
        "docs/coming_from_cpp.md says how to port it"
    )


def _import(declaration: PluginDeclaration) -> object:
    module_name, _, class_name = declaration.class_path.rpartition(".")
    class_name = sys.intern(class_name)  # Python's cache of attributes keeps thousands of others
    try:
        module = importlib.import_module(module_name)
    except Exception as error:
        raise PluginError(
            f'the plugin "{declaration.name}" of the package {declaration.package} cannot be '
            f"imported: {module_name}: {error}"
        ) from error
    if not hasattr(module, class_name):
        raise PluginError(
            f'{module_name} has no class "{class_name}", though its package declares it'
        )
    return getattr(module, class_name)
