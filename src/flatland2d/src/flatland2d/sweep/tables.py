"""The tables of a sweep, with typed columns, as CSV and Parquet; and their summary.

Equal tables are equal files, byte for byte.
"""

import csv
import io
import json
import math
from pathlib import Path
from typing import Any, Dict, Iterable, List, Mapping, NamedTuple, Sequence, Tuple

from flatland2d.sweep.intervals import mean, rate
from flatland2d.sweep.metrics import METRICS, SUMMARISED
from flatland2d.sweep.run import ESTIMATE_ENDS
from flatland2d.sweep.runner import Result
from flatland2d.sweep.settings import Scenario
from flatland_server.config import replacing
from flatland_server.exceptions import FlatlandError, needed_module, pip_install

BOOL, INT, FLOAT, STRING = "bool", "int64", "float64", "string"


class Column(NamedTuple):
    """A column of a table.

    Attributes:
        name: unique in its table.
        type: "bool", "int64", "float64" or "string".
        values: of that type, or None.
    """

    name: str
    type: str
    values: List[Any]


Table = List[Column]


Results = Sequence[Tuple[Scenario, Result]]


def rows_of(results: Results) -> List[Dict[str, Any]]:
    """A row for each scenario, in the order of their numbers."""
    returned = sorted({name for _, result in results for name in result.returned})
    rows = []
    for scenario, result in results:
        row = scenario.columns
        row["status"] = "failed" if result.error else "done"
        row.update({name: result.row.get(name) for name in METRICS})
        row.update({name: result.returned.get(name) for name in returned})
        row["error"] = result.error or None
        rows.append(row)
    return rows


def timing_table(results: Results) -> Table:
    """Real time and attempts, which differ from one run of the sweep to the next."""
    columns: Dict[str, List[Any]] = {
        "scenario": [scenario.number for scenario, _ in results],
        "seconds": [round(result.seconds, 6) for _, result in results],
        "attempts": [result.attempts for _, result in results],
    }
    return [column(name, values) for name, values in columns.items()]


def summary_rows(results: Results) -> List[Dict[str, Any]]:
    """A row for each world, controller and combination of parameters.

    `scenarios`, and of these `failed`: could not be run to the end; they are left out of the rates
    and means. For each of these three columns: the rate or mean, and `_low` and `_high`, the ends
    of its confidence interval, within the metric's range; for means also `_count`.
    """
    groups: Dict[str, List[Tuple[Scenario, Result]]] = {}
    for scenario, result in results:
        groups.setdefault(repr(scenario.group), []).append((scenario, result))
    names = [*SUMMARISED, *_numeric_names(result for _, result in results)]
    return [_summary(group, names) for group in groups.values()]


def _numeric_names(results: Iterable[Result]) -> List[str]:
    """The names of returned values that are numbers or booleans."""
    kinds: Dict[str, bool] = {}
    for result in results:
        for name, value in result.returned.items():
            kinds[name] = kinds.get(name, True) and not isinstance(value, str)
    return sorted(name for name, is_number in kinds.items() if is_number)


def _summary(group: Results, names: Sequence[str]) -> Dict[str, Any]:
    done = [result for _, result in group if not result.error]
    row = {**group[0][0].group, "scenarios": len(group), "failed": len(group) - len(done)}
    for name in names:
        values = [{**result.returned, **result.row}.get(name) for result in done]
        row.update(_estimate(name, [value for value in values if value is not None]))
    return row


def _estimate(name: str, values: List[Any]) -> Dict[str, Any]:
    """A rate of booleans, or a mean of numbers; None where there is no value."""
    is_rate = all(isinstance(value, bool) for value in values)
    if is_rate:
        interval = rate(sum(values), len(values))
    else:
        interval = mean([float(value) for value in values])
        if name in SUMMARISED:
            low, high = max(interval.low, 0.0), min(interval.high, SUMMARISED[name].most)
            interval = interval._replace(low=low, high=high)
    shown = [None if number != number else number for number in interval]
    *ends, count = (f"{name}{end}" for end in ESTIMATE_ENDS)
    found = dict(zip((name, *ends), shown))
    is_of_all = name in SUMMARISED and SUMMARISED[name].is_rate
    return found if is_of_all else {**found, count: len(values)}


def column(name: str, values: Iterable[Any]) -> Column:
    """A column of the type that fits all values.

    Numbers that are not all whole are float64; values of several types, and lists, are strings.
    """
    name = _writable(name)
    found = [text_of(v) if isinstance(v, (list, dict)) else v for v in values]
    types = {type(value) for value in found if value is not None}
    if not types or types == {bool}:
        return Column(name, BOOL if types else FLOAT, found)
    is_small = all(abs(v) < 1 << 63 for v in found if isinstance(v, int))
    if types == {int} and is_small:
        return Column(name, INT, found)
    if types <= {int, float} and is_small:
        return Column(name, FLOAT, [None if v is None else float(v) for v in found])
    return Column(name, STRING, [None if v is None else text_of(v) for v in found])


def table_of(rows: Sequence[Mapping[str, Any]]) -> Table:
    """A table of rows: the columns in the order in which rows have them first."""
    names: Dict[str, None] = {}
    for row in rows:
        names.update(dict.fromkeys(row))
    return [column(name, [row.get(name) for row in rows]) for name in names]


def csv_bytes(table: Table) -> bytes:
    """A table as CSV: floats so that they can be read back exactly; None is empty."""
    file = io.StringIO(newline="")
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow([each.name for each in table])
    for row in zip(*(each.values for each in table)):
        writer.writerow(["" if value is None else text_of(value) for value in row])
    return file.getvalue().encode()


def parquet(table: Table) -> bytes:
    """A table as Parquet.

    Raises:
        MissingPackageError: pyarrow is not installed.
    """
    also = "in a ROS workspace as docs/sweeps.md says under Parquet and Ray"
    install = f"{pip_install('sweep')}, or {also}"
    needed_module("pyarrow.parquet", "a Parquet file needs pyarrow", install)
    import pyarrow.parquet

    types = {
        BOOL: pyarrow.bool_(),
        INT: pyarrow.int64(),
        FLOAT: pyarrow.float64(),
        STRING: pyarrow.string(),
    }
    arrays = [pyarrow.array(each.values, types[each.type]) for each in table]
    content = pyarrow.Table.from_arrays(arrays, names=[each.name for each in table])
    buffer = pyarrow.BufferOutputStream()
    pyarrow.parquet.write_table(content, buffer)
    found: bytes = buffer.getvalue().to_pybytes()
    return found


def write_file(path: Path, content: bytes) -> None:
    """Writes a file atomically: whatever happens, it is the former or the new one.

    Raises:
        FlatlandError: it cannot be written.
    """
    try:
        with replacing(path) as temporary:
            temporary.write_bytes(content)
    except OSError as error:
        raise FlatlandError(f"{path}: cannot be written: {error.strerror}") from None


def _writable(text: str) -> str:
    """A text without lone surrogates, which UTF-8 does not have: they are escaped."""
    return text.encode("utf-8", "backslashreplace").decode()


def text_of(value: Any) -> str:
    """A value as text in a CSV file."""
    if isinstance(value, (list, dict)):
        return json.dumps(value)
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float) and not math.isfinite(value):
        return "nan" if math.isnan(value) else "inf" if value > 0 else "-inf"
    return repr(value) if isinstance(value, float) else _writable(str(value))


def one_line(text: str) -> str:
    """A text for a cell: line breaks and other characters that are not printable become blanks."""
    return "".join(each if each.isprintable() else " " for each in text)
