"""The random numbers of plugins, each with a stream of its own."""

import zlib
from functools import lru_cache
from typing import Any, Optional, Tuple

import numpy as np
from numpy.random.bit_generator import ISpawnableSeedSequence


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
