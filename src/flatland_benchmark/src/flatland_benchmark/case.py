"""A case of the benchmark: a name, a sentence, and what measures it."""

from pathlib import Path
from typing import Callable, Dict, NamedTuple

#: Numbers by name; a name ends in its unit, in brackets: "load [s]".
Figures = Dict[str, float]


class Case(NamedTuple):
    """Something that is measured, each time in a process of its own."""

    name: str  # a word for the command line
    description: str  # a sentence without a full stop
    run: Callable[[Path], Figures]  # given the folder of the package's worlds
