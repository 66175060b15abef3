"""A case of the benchmark: a name, a description, and the function that measures it."""

from pathlib import Path
from typing import Callable, Dict, NamedTuple

#: Numbers by name; a name ends in its unit, in brackets: "load [s]".
Figures = Dict[str, float]


class Case(NamedTuple):
    """Something to measure. Each run is a process of its own."""

    name: str  # as typed on the command line
    description: str  # a sentence without a full stop
    run: Callable[[Path], Figures]  # takes the folder of flatland_server's worlds
