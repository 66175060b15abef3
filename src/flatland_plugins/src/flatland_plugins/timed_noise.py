"""Noise that depends on the seed and the time only, not on earlier messages or subscribers."""

import numpy as np


class TimedNoise:
    """A random generator for each time.

    Args:
        rng: of the plugin; one number is drawn from it, as the seed.
    """

    def __init__(self, rng: np.random.Generator) -> None:
        self._key = int(rng.integers(2**63))

    def at(self, nanoseconds: int) -> np.random.Generator:
        """The generator for a time [ns]: equal times give equal numbers."""
        return np.random.default_rng([self._key, nanoseconds])
