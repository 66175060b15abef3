"""Figures and words that several cases share."""

import resource
import statistics
from typing import List

from flatland_benchmark.case import Figures

ROBOTS = (1, 10, 50, 100, 1000)
"""How many robots there are in the cases that differ in that."""


def in_words(robots: int) -> str:
    """So many robots."""
    return "1 robot" if robots == 1 else f"{robots} robots"


def durations(seconds: List[float]) -> Figures:
    """What is usual, and what is rarely exceeded."""
    return {
        "median [ms]": statistics.median(seconds) * 1e3,
        "p99 [ms]": sorted(seconds)[int(0.99 * (len(seconds) - 1))] * 1e3,
    }


def peak_memory() -> Figures:
    """The most that this process has had in memory."""
    return {"memory [MB]": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024}
