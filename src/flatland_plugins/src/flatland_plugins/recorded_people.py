"""Recorded people: a file of their positions, in the form of the ETH and UCY data sets."""

import math
from dataclasses import dataclass
from heapq import heappush, heapreplace
from pathlib import Path
from typing import Dict, List, Sequence, Tuple

import numpy as np

from flatland_plugins.agents import FARTHEST
from flatland_server import (
    FlatlandError,
    FloatArray,
    Point,
    Pose,
    Problem,
    YamlError,
    YamlReader,
    read_input,
)

_LARGEST_FILE = 64 * 1024 * 1024  # bytes
_LONGEST = 1e6  # s
_COLUMNS = ["frame", "id", "x", "y"]
_PAUSE = 1.0  # s, of a body between two people

Walk = FloatArray
"""Of one person: rows of time [s], x and y [m], in the order of their times."""


@dataclass(frozen=True)
class RecordedPeople:
    """The section `recording`: people who walk as they were recorded.

    Attributes:
        bodies: the walks that each body follows, one after the other.
        start: the range of the recording's times at which a world begins [s].
        reader: of the section.
    """

    bodies: Tuple[Tuple[Walk, ...], ...]
    start: Tuple[float, float]
    reader: YamlReader

    @classmethod
    def read(cls, reader: YamlReader) -> "RecordedPeople":
        """Reads the keys and the file.

        Raises:
            YamlError: something in them is wrong.
        """
        path = reader.get_path("file")
        frame_rate = reader.get_float("frame_rate", 25.0, above=0.0)
        origin = reader.get_pose("pose", Pose())
        first, last = reader.get_floats("start", 2, (0.0, 0.0), minimum=0.0)
        if first > last:
            reader.problem(f"expected ascending times, found [{first:g}, {last:g}]", "start")
        reader.finish()
        walks = _walks(path, frame_rate, origin)
        end = max(float(walk[-1, 0]) for walk in walks)
        if end > _LONGEST:
            expected = f"expected a recording of up to {_LONGEST:g} s"
            raise reader.error(f"{expected}, found {end:g} s at this rate", "frame_rate")
        if last > end:
            raise reader.error(f"expected times up to the end, {end:g} s, found {last:g}", "start")
        return cls(_bodies(walks), (first, last), reader)


def _walks(path: Path, frame_rate: float, origin: Pose) -> List[Walk]:
    """The walks in a file, in the order of their beginnings; the first one begins at 0.

    Raises:
        YamlError: the file is no recording; its lines are named.
    """
    people: Dict[float, Dict[float, Point]] = {}
    problems = []
    text = read_input(path, _LARGEST_FILE).decode("utf-8-sig", "replace")
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.replace(",", " ").split()
        if not words or words[0].startswith("#") or (not people and words == _COLUMNS):
            continue
        try:
            frame, person, *point = _row(line, words)
            frames = people.setdefault(person, {})
            if frame in frames:
                raise FlatlandError(f"person {words[1]} is in frame {words[0]} a second time")
            frames[frame] = (point[0], point[1])
        except FlatlandError as error:
            problems.append(Problem(path, str(error), number))
    if problems:
        raise YamlError.of(problems)
    if not people:
        raise YamlError(path, f"expected rows of {', '.join(_COLUMNS)}, found none")
    first = min(map(min, people.values()))
    walks = [
        np.array([((k - first) / frame_rate, *origin.apply(*frames[k])) for k in sorted(frames)])
        for frames in people.values()
    ]
    return sorted(walks, key=lambda walk: float(walk[0, 0]))


def _row(line: str, words: Sequence[str]) -> List[float]:
    """The numbers of a line.

    Raises:
        FlatlandError: it is something else.
    """
    try:
        numbers = [float(word) for word in words]
    except ValueError:
        numbers = []
    if len(numbers) != len(_COLUMNS) or not all(map(math.isfinite, numbers)):
        expected = f"expected four numbers, {', '.join(_COLUMNS)}"
        raise FlatlandError(f"{expected}, found {line.strip()[:80]!r}")
    if max(map(abs, numbers[2:])) >= FARTHEST:
        raise FlatlandError(f"expected a position within {FARTHEST:g} m, found {numbers[2:]}")
    if not all(number.is_integer() for number in numbers[:2]):
        raise FlatlandError(f"expected a whole frame and id, found {words[0]}, {words[1]}")
    return numbers


def _bodies(walks: Sequence[Walk]) -> Tuple[Tuple[Walk, ...], ...]:
    """The walks by bodies: as few as can show all of them."""
    bodies: List[List[Walk]] = []
    ends: List[Tuple[float, int]] = []  # a heap: of the last walk of each body
    for walk in walks:
        begin, end = float(walk[0, 0]), float(walk[-1, 0])
        if ends and ends[0][0] + _PAUSE <= begin:
            body = heapreplace(ends, (end, ends[0][1]))[1]
            bodies[body].append(walk)
        else:
            heappush(ends, (end, len(bodies)))
            bodies.append([walk])
    return tuple(map(tuple, bodies))
