"""Makes plugins out of their configuration."""

import zlib
from functools import lru_cache
from typing import Any, Callable, Optional, Tuple, Type, TypeVar

import numpy as np
from numpy.random.bit_generator import ISpawnableSeedSequence

from flatland_server.exceptions import (
    PLUGIN_ERRORS,
    FlatlandError,
    PluginError,
    TopicError,
    YamlError,
)
from flatland_server.models.plugin_config import PluginConfig
from flatland_server.plugins.plugin import Plugin, plugin_label
from flatland_server.plugins.plugin_loader import PluginLoader
from flatland_server.transport.node import Node

P = TypeVar("P", bound=Plugin)


class PluginFactory:
    """Makes plugins, each with a node and a random number generator of its own.

    Args:
        root_node: the parent of their nodes.
        loader: finds plugin classes.
        seed: the world's seed.
    """

    def __init__(self, root_node: Node, loader: PluginLoader, seed: int) -> None:
        self._root_node = root_node
        self._loader = loader
        self._seed = seed

    def make(
        self,
        config: PluginConfig,
        base: Type[P],
        model_name: str,
        namespace: str,
        subject: Any,
        on_failure: Callable[[P, str], None],
    ) -> P:
        """Makes a plugin and initializes it.

        Args:
            config: the plugin's entry in the file of a model or of the world.
            base: base class that the plugin must have.
            model_name: name of its model; empty for a plugin of the world.
            namespace: its topics' namespace.
            subject: the model, or the world, that the plugin belongs to.
            on_failure: called with the plugin and a description of the callback, if a callback of
                one of its subscriptions raises an exception.

        Raises:
            FlatlandError: there is no such plugin, or it does not start. It leaves no topics.
        """
        reader = config.reader
        try:
            plugin_class = self._loader.load(config.type, base)
        except PluginError as error:
            raise reader.error(str(error), "type") from error.__cause__
        rng = plugin_rng(self._seed, model_name, config.name)
        node = self._root_node.scoped(namespace, plugin_label(model_name, config.name))
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


def plugin_rng(seed: int, model_name: str, plugin_name: str) -> np.random.Generator:
    """The random numbers of a plugin.

    Args:
        seed: the world's seed.
        model_name: name of its model; empty for a plugin of the world.
        plugin_name: name of the plugin.
    """
    seeds: Any = _Seeds(seed, _stream(model_name, plugin_name))
    return np.random.Generator(np.random.PCG64(seeds))


class _Seeds(ISpawnableSeedSequence):
    """The same as `SeedSequence([seed, stream])`, which takes 15 us; resets need it again."""

    def __init__(self, seed: int, stream: int) -> None:
        self._numbers = (seed, stream)
        self._sequence: Optional[np.random.SeedSequence] = None

    def generate_state(self, n_words: int, dtype: Any = np.uint32) -> Any:
        return _seed_words(self._numbers, n_words, dtype)

    def spawn(self, n_children: int) -> Any:
        if self._sequence is None:
            self._sequence = np.random.SeedSequence(self._numbers)
        return self._sequence.spawn(n_children)


@lru_cache(maxsize=1024)
def _seed_words(numbers: Tuple[int, int], count: int, dtype: Any) -> Any:
    return np.random.SeedSequence(numbers).generate_state(count, dtype)


def _stream(model_name: str, plugin_name: str) -> int:
    """The number of a plugin's random stream: one for each pair of names.

    Slashes within the names are doubled, so that plugin "b/c" of model "a" does not share the
    stream of plugin "c" of model "a/b".
    """
    names = [name.replace("/", "//") for name in (model_name, plugin_name) if name]
    return zlib.crc32("/".join(names).encode())
