"""Figures and words shared by several cases."""

import resource
import statistics
from typing import List

from flatland_benchmark.case import Figures

ROBOTS = (1, 10, 50, 100, 1000)
"""Numbers of robots in cases that come in several sizes."""


def in_words(robots: int) -> str:
    """A number of robots, as text."""
    return "1 robot" if robots == 1 else f"{robots} robots"


def durations(seconds: List[float]) -> Figures:
    """Median and 99th percentile."""
    return {
        "median [ms]": statistics.median(seconds) * 1e3,
        "p99 [ms]": sorted(seconds)[int(0.99 * (len(seconds) - 1))] * 1e3,
    }


def peak_memory() -> Figures:
    """The peak resident memory of this process."""
    return {"memory [MB]": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024}
