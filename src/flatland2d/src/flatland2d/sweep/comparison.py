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

import math
from itertools import combinations
from typing import Any, Collection, Dict, List, Mapping, NamedTuple, Sequence, Tuple

import numpy as np

from flatland2d.sweep.intervals import CONFIDENCE
from flatland2d.sweep.metrics import SUMMARISED
from flatland_server.exceptions import FlatlandError, needed_module, pip_install

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
