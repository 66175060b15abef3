"""Tables with typed columns, as CSV and Parquet. Equal tables are equal files, byte for byte."""

import csv
import io
import json
import math
import os
from pathlib import Path
from typing import Any, Dict, Iterable, List, Mapping, NamedTuple, Sequence

import numpy as np

from flatland_server.exceptions import FlatlandError
from flatland_server.sweep.extras import how_to_install

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


def column(name: str, values: Iterable[Any]) -> Column:
    """A column of the type that fits all values.

    Numbers that are not all whole are float64; values of several types, and lists, are strings.
    """
    found = [_plain(value) for value in values]
    types = {type(value) for value in found if value is not None}
    if not types or types == {bool}:
        return Column(name, BOOL if types else FLOAT, found)
    is_small = all(abs(v) < 1 << 63 for v in found if isinstance(v, int))
    if types == {int} and is_small:
        return Column(name, INT, found)
    if types <= {int, float} and is_small:
        return Column(name, FLOAT, [None if v is None else float(v) for v in found])
    return Column(name, STRING, [None if v is None else _text(v) for v in found])


def table_of(rows: Sequence[Mapping[str, Any]]) -> Table:
    """A table of rows: the columns in the order in which rows have them first."""
    names: Dict[str, None] = {}
    for row in rows:
        names.update(dict.fromkeys(row))
    return [column(name, [row.get(name) for row in rows]) for name in names]


def write_csv(path: Path, table: Table) -> None:
    """Writes a table as CSV: floats so that they can be read back exactly; None is empty.

    Raises:
        FlatlandError: the file cannot be written.
    """
    file = io.StringIO(newline="")
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow([each.name for each in table])
    for row in zip(*(each.values for each in table)):
        writer.writerow(["" if value is None else _text(value) for value in row])
    write_file(path, file.getvalue().encode())


def write_parquet(path: Path, table: Table) -> None:
    """Writes a table as Parquet.

    Raises:
        FlatlandError: pyarrow is not installed, or the file cannot be written.
    """
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError as error:
        reason = str(error).splitlines()[0]
        package = "'pyarrow<24'" if np.__version__ < "2" else "pyarrow"  # 24 needs NumPy 2
        raise FlatlandError(
            f"a Parquet file needs pyarrow: {how_to_install('sweep', package)} ({reason})"
        ) from None
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
    write_file(path, buffer.getvalue().to_pybytes())


def write_file(path: Path, content: bytes) -> None:
    """Writes a file atomically: whatever happens, it is the former or the new one.

    Raises:
        FlatlandError: it cannot be written.
    """
    temporary = path.with_name(f".{path.name}.new")
    try:
        temporary.write_bytes(content)
        os.replace(temporary, path)
    except OSError as error:
        raise FlatlandError(f"{path}: cannot be written: {error.strerror}") from None


def _plain(value: Any) -> Any:
    if isinstance(value, (list, dict)):
        return json.dumps(value)
    return value


def _text(value: Any) -> str:
    """A value as CSV has it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float) and not math.isfinite(value):
        return "nan" if math.isnan(value) else "inf" if value > 0 else "-inf"
    return repr(value) if isinstance(value, float) else str(value)
