"""Noise that depends on the seed and the time only, not on earlier messages or subscribers."""

import numpy as np


class TimedNoise:
    """A random generator for each time.

    Args:
        rng: of the plugin; one number is drawn from it, as the seed.
    """

    def __init__(self, rng: np.random.Generator) -> None:
        self._key = draw_key(rng)

    def at(self, nanoseconds: int) -> np.random.Generator:
        """The generator for a time [ns]: equal times give equal numbers."""
        return np.random.default_rng([self._key, nanoseconds])


def draw_key(rng: np.random.Generator) -> int:
    """The key of a noise: one number from a plugin's generator."""
    return int(rng.integers(2**63))
