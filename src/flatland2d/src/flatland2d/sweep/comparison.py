"""Paired comparisons: of controllers, and of a sweep with the results of a former one.

Runs are paired by world, parameters and seed, so that both of a pair had the same task.

- Rates: McNemar's exact test, a binomial test of the pairs in which the two differ (Q. McNemar,
  "Note on the sampling error of the difference between correlated proportions", 1947).
- Numbers: Wilcoxon's signed-rank test of the differences other than 0 (F. Wilcoxon, "Individual
  comparisons by ranking methods", 1945). Pairs in which both have a value count: of the time to
  the goal, those in which both have reached it.
- The interval of a mean difference is the percentile bootstrap of the pairs (B. Efron, R.
  Tibshirani, "An Introduction to the Bootstrap", 1993, chapter 13).
- The p-values of a table are adjusted by Holm's method (S. Holm, "A simple sequentially rejective
  multiple test procedure", 1979): its level is the probability of any false finding in the table.
"""

import csv
import io
import math
from itertools import combinations
from pathlib import Path
from typing import Any, Collection, Dict, List, Mapping, NamedTuple, Sequence, Set, Tuple
from xml.etree import ElementTree

import numpy as np

from flatland2d.sweep.intervals import CONFIDENCE
from flatland2d.sweep.metrics import SUMMARISED
from flatland_server.config import MAX_IMAGE, read_input, refusal_by
from flatland_server.exceptions import FlatlandError, listed, needed_module, pip_install

_RESAMPLES = 9999

TextRow = Mapping[str, str]
"""A row of results.csv."""

Task = Tuple[str, ...]
"""World and parameters, and the seed, too, if it is that of a run."""

Runs = Dict[Task, Dict[str, Any]]
"""The metrics of runs by their tasks."""


class Comparison(NamedTuple):
    """A metric in two sets of runs with the same tasks.

    Attributes:
        pairs: number of pairs with a value in both.
        mean: of the first ones of these pairs; NaN without pairs.
        other_mean: of the second ones.
        low: lower end of the confidence interval of the mean difference, first minus second.
        high: its upper end.
        p: p-value.
    """

    pairs: int
    mean: float
    other_mean: float
    low: float
    high: float
    p: float


def scipy_stats() -> Any:
    """The module of SciPy, which only comparisons need.

    Raises:
        MissingPackageError: it is not installed.
    """
    install = f"apt-get install python3-scipy, or {pip_install('sweep')}"
    return needed_module("scipy.stats", "comparisons need SciPy", install)


def compare(first: Runs, second: Runs, name: str, worse: bool = False) -> Comparison:
    """Compares a metric in two sets of runs.

    Args:
        first: runs by their tasks.
        second: runs by their tasks; tasks that only one of the two has are left out.
        name: name of a metric in SUMMARISED.
        worse: whether to test for a change for the worse alone, from the second to the first;
            else for any difference.

    Raises:
        MissingPackageError: SciPy is missing.
    """
    stats = scipy_stats()
    metric = SUMMARISED[name]
    pairs = [(first[task].get(name), second[task].get(name)) for task in first if task in second]
    values = [(a, b) for a, b in pairs if a is not None and b is not None]
    if not values:
        return Comparison(0, math.nan, math.nan, math.nan, math.nan, 1.0)
    array = np.array(values, dtype=float)
    differences = array[:, 0] - array[:, 1]
    changed = differences[differences != 0]
    alternative = "two-sided" if not worse else "less" if metric.better > 0 else "greater"
    p = 1.0
    if len(changed) and metric.is_rate:
        test = stats.binomtest(int((changed > 0).sum()), len(changed), alternative=alternative)
        p = float(test.pvalue)
    elif len(changed):
        p = float(stats.wilcoxon(changed, alternative=alternative).pvalue)
    low = high = float(differences[0])
    if len(set(differences.tolist())) > 1:
        interval = stats.bootstrap(
            (differences,),
            np.mean,
            n_resamples=_RESAMPLES,
            confidence_level=CONFIDENCE,
            method="percentile",
            batch=256,
            random_state=np.random.default_rng(0),
        ).confidence_interval
        low, high = float(interval.low), float(interval.high)
    mean, other_mean = array.mean(axis=0).tolist()
    return Comparison(len(values), mean, other_mean, low, high, p)


def holm(p_values: Sequence[float]) -> List[float]:
    """P-values adjusted by Holm's method, in the same order."""
    adjusted = [0.0] * len(p_values)
    largest = 0.0
    for rank, index in enumerate(sorted(range(len(p_values)), key=p_values.__getitem__)):
        largest = max(largest, min(1.0, (len(p_values) - rank) * p_values[index]))
        adjusted[index] = largest
    return adjusted


def runs_of(rows: Sequence[TextRow], worlds: Mapping[str, str] = {}) -> Dict[Task, Dict[str, Runs]]:
    """The runs of a table by world and parameters, and by controller; without failed ones.

    Args:
        rows: of results.csv.
        worlds: the groups of worlds that are compared as one, by their names.

    Raises:
        FlatlandError: a value is of another kind than its column's.
    """
    found: Dict[Task, Dict[str, Runs]] = {}
    for row in rows:
        if row["status"] == "done":
            task = task_of(row)
            group = (worlds.get(row["world"], task[0]), *task[1:-1])
            runs = found.setdefault(group, {}).setdefault(row["controller"], {})
            runs[task] = {name: _value(row, name) for name in SUMMARISED}
    return found


def task_of(row: TextRow) -> Task:
    """The world, the parameters and the seed of a row."""
    return tuple(comparable(row[name]) for name in (*group_names(row), "seed"))


def group_names(row: TextRow) -> List[str]:
    """The columns of world and parameters."""
    names = list(row)
    return ["world", *names[names.index("controller") + 1 : names.index("seed")]]


def comparison_rows(
    rows: Sequence[TextRow], worlds: Mapping[str, str], metrics: Collection[str] = SUMMARISED
) -> List[Dict[str, Any]]:
    """A row for each two controllers and each metric, by world and parameters.

    Args:
        rows: of results.csv.
        worlds: see `runs_of`.
        metrics: names in SUMMARISED; the p-values are adjusted for these.

    Raises:
        MissingPackageError: SciPy is missing.
    """
    found: List[Dict[str, Any]] = []
    for group, controllers in runs_of(rows, worlds).items():
        for first, second in combinations(controllers, 2):
            for name in metrics:
                result = compare(controllers[first], controllers[second], name)
                columns = {"controller": first, "against": second, "metric": name}
                if result.pairs:
                    described = dict(zip(group_names(rows[0]), group))
                    found.append({**described, **columns, **result._asdict()})
    for row, p in zip(found, holm([row["p"] for row in found])):
        row["p"] = p
    return found


def comparable(text: str) -> str:
    """A value of a table, where 1 and 1.0 are the same: a column with fractions has the latter."""
    try:
        return repr(float(text))
    except ValueError:
        return text


def _value(row: TextRow, name: str) -> Any:
    """A metric of a row: a boolean, a number or None.

    Raises:
        FlatlandError: it is something else.
    """
    text = row.get(name, "")
    if text in ("", "true", "false"):
        return {"": None, "true": True, "false": False}[text]
    try:
        return float(text)
    except ValueError:
        raise FlatlandError(
            f"scenario {row['scenario']}: expected a number in {name}, found {text!r}"
        ) from None


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
