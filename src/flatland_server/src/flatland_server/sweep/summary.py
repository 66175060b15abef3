"""The table of a sweep's results, and their summary by world, controller and parameters."""

from typing import Any, Dict, Iterable, List, Mapping, Sequence, Tuple

from flatland_server.sweep.intervals import mean, rate
from flatland_server.sweep.journal import Entry
from flatland_server.sweep.scenario import Scenario
from flatland_server.sweep.table import Table, table_of

METRICS = (
    "outcome",
    "success",
    "collision",
    "time",
    "time_to_goal",
    "path_length",
    "min_clearance",
    "goal_distance",
    "start_x",
    "start_y",
    "start_yaw",
    "goal_x",
    "goal_y",
)
"""What is measured in each scenario, in the order of the table's columns."""

_SUMMARISED = ("success", "collision", "time_to_goal", "path_length", "min_clearance")

Results = Sequence[Tuple[Scenario, Entry]]


def rows_of(results: Results) -> List[Dict[str, Any]]:
    """A row for each scenario, in the order of their numbers."""
    returned = sorted({name for _, entry in results for name in entry.result.returned})
    rows = []
    for scenario, entry in results:
        result = entry.result
        row = scenario.columns
        row["status"] = "failed" if result.error else "done"
        row.update({name: result.row.get(name) for name in METRICS})
        row.update({name: result.returned.get(name) for name in returned})
        row["error"] = result.error or None
        rows.append(row)
    return rows


def timing_table(results: Results) -> Table:
    """What differs from one run of the sweep to the next: real time and attempts."""
    return table_of(
        [
            {
                "scenario": scenario.number,
                "seconds": round(entry.seconds, 6),
                "attempts": entry.attempts,
            }
            for scenario, entry in results
        ]
    )


def summary_rows(results: Results) -> List[Dict[str, Any]]:
    """A row for each world, controller and combination of parameters.

    `scenarios`, and of these `failed`: could not be run to the end; they are left out of the rates
    and means. For each of these three columns: the rate or mean, and `_low` and `_high`, the ends
    of its confidence interval; for means also `_count`.
    """
    groups: Dict[str, List[Tuple[Scenario, Entry]]] = {}
    for scenario, entry in results:
        groups.setdefault(repr(scenario.group), []).append((scenario, entry))
    names = [*_SUMMARISED, *_numeric_names(entry for _, entry in results)]
    return [_summary(group, names) for group in groups.values()]


def _numeric_names(entries: Iterable[Entry]) -> List[str]:
    """The names of returned values that are numbers or booleans."""
    kinds: Dict[str, bool] = {}
    for entry in entries:
        for name, value in entry.result.returned.items():
            kinds[name] = kinds.get(name, True) and not isinstance(value, str)
    return sorted(name for name, is_number in kinds.items() if is_number)


def _summary(group: Results, names: Sequence[str]) -> Dict[str, Any]:
    done = [entry.result for _, entry in group if not entry.result.error]
    row = {**group[0][0].group, "scenarios": len(group), "failed": len(group) - len(done)}
    for name in names:
        values = [_value(result.row, result.returned, name) for result in done]
        row.update(_estimate(name, [value for value in values if value is not None]))
    return row


def _value(row: Mapping[str, Any], returned: Mapping[str, Any], name: str) -> Any:
    return row[name] if name in row else returned.get(name)


def _estimate(name: str, values: List[Any]) -> Dict[str, Any]:
    """A rate of booleans, or a mean of numbers; None where there is no value."""
    is_rate = all(isinstance(value, bool) for value in values)
    if is_rate:
        interval = rate(sum(values), len(values))
    else:
        interval = mean([float(value) for value in values])
    shown = [None if number != number else number for number in interval]
    found = dict(zip((name, f"{name}_low", f"{name}_high"), shown))
    return found if name in ("success", "collision") else {**found, f"{name}_count": len(values)}
