"""Cases of the benchmark: functions that measure something, and are registered with `@case`."""

from functools import partial
from itertools import product
from pathlib import Path
from typing import Any, Callable, Dict, NamedTuple, Sequence

#: Numbers by name; a name ends in its unit, in brackets: "load [s]".
Figures = Dict[str, float]


class Case(NamedTuple):
    """Something to measure. Each run is a process of its own."""

    name: str  # as typed on the command line
    description: str  # a sentence without a full stop
    run: Callable[[Path], Figures]  # takes the folder of flatland_server's worlds


CASES: Dict[str, Case] = {}
"""All cases by name, in the order in which they run; `flatland_benchmark.cases` fills it."""


def case(name: str, description: str, **values: Sequence[Any]) -> Callable[[Any], Any]:
    """Registers a function of the worlds' folder as a case.

    With keyword arguments, it is a case for each combination of their values: the function gets
    them by these names, and name and description have them in braces, as in `"serve_{robots}"`.
    """

    def register(function: Callable[..., Figures]) -> Callable[..., Figures]:
        for combination in product(*values.values()):
            given = dict(zip(values, combination))
            full = name.format(**given)
            CASES[full] = Case(full, description.format(**given), partial(function, **given))
        return function

    return register
