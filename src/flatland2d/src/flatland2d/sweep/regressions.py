"""A gate for continuous integration: whether a sweep is worse than the results of a former one."""

import csv
import io
import math
from pathlib import Path
from typing import Dict, List, Mapping, NamedTuple, Sequence, Set
from xml.etree import ElementTree

from flatland2d.sweep.comparison import (
    Comparison,
    Task,
    TextRow,
    compare,
    group_names,
    holm,
    runs_of,
    task_of,
)
from flatland2d.sweep.metrics import SUMMARISED
from flatland_server.config import MAX_IMAGE, read_input, refusal_by
from flatland_server.exceptions import FlatlandError, listed

LEVEL = 0.01
"""Probability of a false alarm of a whole gate, if nothing has changed but chance."""

_GATED = [name for name, metric in SUMMARISED.items() if metric.is_gated]


class Verdict(NamedTuple):
    """One comparison of the gate.

    Attributes:
        name: world, parameters and controller.
        metric: the metric's column.
        result: the runs of now against those of the baseline; the p-value is adjusted.
        is_regression: whether they are significantly worse, by more than the tolerance.
    """

    name: str
    metric: str
    result: Comparison
    is_regression: bool

    def __str__(self) -> str:
        pairs, now, before, _, _, p = self.result
        if not pairs:
            return f"{self.name}: {self.metric}: no run in both"
        unit = SUMMARISED[self.metric].label
        return f"{self.name}: {unit} {now:.4g}, before {before:.4g} ({pairs} pairs, p = {p:.2g})"


def read_rows(path: Path) -> List[Dict[str, str]]:
    """The rows of a sweep's results.

    Args:
        path: of results.csv, or of its folder.

    Raises:
        FlatlandError: it cannot be read, or is no such table.
    """
    file = path / "results.csv" if path.is_dir() else path
    try:
        text = read_input(file, MAX_IMAGE, refusal_by(FlatlandError)).decode()
        rows = list(csv.DictReader(io.StringIO(text, newline=""), strict=True))
    except (csv.Error, UnicodeDecodeError) as error:
        raise FlatlandError(f"{file}: expected results.csv of a sweep: {error}") from None
    needed = ["scenario", "world", "controller", "seed", "status", *_GATED]
    missing = [name for name in needed if not rows or name not in rows[0]]
    if missing:
        raise FlatlandError(
            f"{file}: expected results.csv of a sweep, found no column {listed(missing)}"
        )
    for number, row in enumerate(rows, 1):
        if None in row or None in row.values():
            raise FlatlandError(f"{file}: expected as many values as columns in row {number}")
    return rows


def verdicts(
    rows: Sequence[TextRow],
    baseline: Sequence[TextRow],
    tolerance: float,
    worlds: Mapping[str, str] = {},
) -> List[Verdict]:
    """Compares the runs of a sweep with those of the same tasks in a former one.

    Args:
        rows: see `read_rows`.
        baseline: rows of the former sweep.
        tolerance: changes of a mean up to this fraction of the former one are none; of a rate, up
            to this difference.
        worlds: see `runs_of`.

    Raises:
        FlatlandError: SciPy is missing, a value is wrong, the baseline lacks tasks of the sweep or
            has one twice, or no run is in both.
    """
    names, former = group_names(rows[0]), group_names(baseline[0])
    if names != former:
        raise FlatlandError(
            f"the baseline is of another sweep: expected results by {listed(names)}; found "
            f"{listed(former)}"
        )
    known = _tasks(baseline)
    lacking = [row["scenario"] for row in rows if (row["controller"], *task_of(row)) not in known]
    if lacking:
        raise FlatlandError(
            "the baseline has no scenario with the same world, controller, parameters and seed for "
            f"{len(lacking)} of {len(rows)}: {listed(lacking)}; make a new baseline"
        )
    before = runs_of(baseline, worlds)
    found = [
        (", ".join((*group, controller)), name, compare(runs, others, name, worse=True))
        for group, controllers in runs_of(rows, worlds).items()
        for controller, runs in controllers.items()
        for others in [before.get(group, {}).get(controller, {})]
        for name in _GATED
    ]
    if not any(result.pairs for _, _, result in found):
        raise FlatlandError("no scenario has run to its end both now and in the baseline")
    for label, name, result in found:
        if result.pairs and not math.isfinite(result.mean + result.other_mean):
            raise FlatlandError(f"{label}: expected finite numbers in {name}")
    adjusted = holm([result.p for _, _, result in found])
    return [
        Verdict(label, name, each._replace(p=p), p <= LEVEL and _is_beyond(each, name, tolerance))
        for (label, name, each), p in zip(found, adjusted)
    ]


def _tasks(rows: Sequence[TextRow]) -> Set[Task]:
    """The controllers and tasks of a baseline."""
    found: Set[Task] = set()
    for row in rows:
        task = (row["controller"], *task_of(row))
        if task in found:
            raise FlatlandError(f"the baseline has scenario {row['scenario']} twice")
        found.add(task)
    return found


def junit(title: str, found: Sequence[Verdict]) -> bytes:
    """The comparisons as JUnit XML, which CI services show: a test case for each."""
    suite = ElementTree.Element(
        "testsuite",
        name=title,
        tests=str(len(found)),
        failures=str(sum(each.is_regression for each in found)),
        skipped=str(sum(not each.result.pairs for each in found)),
    )
    for each in found:
        case = ElementTree.SubElement(
            suite, "testcase", classname=_printable(each.name), name=each.metric
        )
        if each.is_regression:
            ElementTree.SubElement(case, "failure", message=_printable(str(each)))
        elif not each.result.pairs:
            ElementTree.SubElement(case, "skipped", message="no run in both")
    text: bytes = ElementTree.tostring(suite, encoding="utf-8", xml_declaration=True)
    return text + b"\n"


def _printable(text: str) -> str:
    """A text without the characters that XML does not have."""
    return "".join(each if each.isprintable() else "\N{REPLACEMENT CHARACTER}" for each in text)


def _is_beyond(result: Comparison, name: str, tolerance: float) -> bool:
    scale = 1.0 if SUMMARISED[name].is_rate else abs(result.other_mean)
    return abs(result.mean - result.other_mean) > tolerance * scale
