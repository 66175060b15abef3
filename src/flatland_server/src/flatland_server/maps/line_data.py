"""Reads the text files of line segments."""

import math
from array import array
from pathlib import Path
from typing import List, Tuple

import numpy as np

from flatland_server.arrays import IntArray, Segments
from flatland_server.config.input_files import MAX_LINE_SEGMENTS, read_input
from flatland_server.config.yaml_map import warn_once
from flatland_server.config.yaml_values import LARGEST
from flatland_server.exceptions import YamlError, counted, shortened


def read_line_segments(path: Path) -> Tuple[Segments, IntArray]:
    """The segments of a text file with a line `x1 y1 x2 y2` for each, in the file's unit.

    `#` begins a comment. What follows the four numbers is ignored, with a warning.

    Returns:
        Segments: shape (n, 4). The numbers of their lines, from 1: shape (n,).
    """
    try:
        lines = read_input(path, MAX_LINE_SEGMENTS).decode("utf-8-sig").splitlines()
    except UnicodeDecodeError:
        raise YamlError(path, "cannot be read: it is not UTF-8 text") from None
    values = array("d")
    numbers = array("q")
    longer: List[int] = []
    for number, line in enumerate(lines, start=1):
        line = line.partition("#")[0].strip()
        if not line:
            continue
        words = line.split()
        try:
            row = [float(word) for word in words[:4]]
        except ValueError:
            row = []
        if len(row) != 4 or not all(map(math.isfinite, row)):
            message = f'expected four numbers, x1 y1 x2 y2, found "{shortened(line)}"'
            raise YamlError(path, message, number)
        if max(map(abs, row)) > LARGEST:
            message = f'expected numbers within {LARGEST:g} of zero, found "{shortened(line)}"'
            raise YamlError(path, message, number)
        if len(words) > 4:
            longer.append(number)
        values.extend(row)
        numbers.append(number)
    if longer:
        rest = "" if len(longer) == 1 else f", and in {counted(len(longer) - 1, 'further line')}"
        message = f"expected four numbers, x1 y1 x2 y2, found more{rest}: it is ignored"
        warn_once(str(YamlError(path, message, longer[0])))
    return np.array(values, dtype=np.float64).reshape(-1, 4), np.array(numbers, dtype=np.intp)
