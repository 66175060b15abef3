"""Noise that depends on the seed and the time alone, not on who has listened so far."""

import numpy as np


class TimedNoise:
    """A source of chance for each moment.

    Args:
        rng: of the plugin whose noise it is; a number is drawn from it.
    """

    def __init__(self, rng: np.random.Generator) -> None:
        self._key = int(rng.integers(2**63))

    def at(self, nanoseconds: int) -> np.random.Generator:
        """The source for a time [ns]: at equal times it gives equal numbers."""
        return np.random.default_rng([self._key, nanoseconds])
