"""A sweep: runs the scenarios without a result, and writes tables, a summary and a report."""

import fcntl
import json
import os
import shlex
import zlib
from collections import Counter
from dataclasses import asdict, replace
from pathlib import Path
from typing import (
    Any,
    Callable,
    Collection,
    Dict,
    Iterable,
    Iterator,
    List,
    NamedTuple,
    Tuple,
    Union,
)

from flatland2d.sweep.comparison import comparison_rows, read_rows
from flatland2d.sweep.fingerprints import Fingerprints
from flatland2d.sweep.local_pool import LocalPool
from flatland2d.sweep.metrics import SUMMARISED
from flatland2d.sweep.paper import figure, latex_table, markdown_table, with_metrics
from flatland2d.sweep.ray_pool import RayPool
from flatland2d.sweep.report import draw, report_html, unsuccessful
from flatland2d.sweep.runner import Result, ScenarioRunner
from flatland2d.sweep.settings import Scenario, SweepSettings, scenarios_of
from flatland2d.sweep.tables import (
    csv_bytes,
    parquet,
    rows_of,
    summary_rows,
    table_of,
    timing_table,
    write_file,
)
from flatland_server.exceptions import FlatlandError, MissingPackageError

JOURNAL = "journal.jsonl"

_HEADER = b'{"format": "flatland sweep 1"}\n'
_CHECKSUM = b', "crc32": '
"""Separates the content of a line from its CRC-32."""


Pool = Union[LocalPool, RayPool]


class Written(NamedTuple):
    """The outcome of writing the results."""

    summary: List[Dict[str, Any]]
    """See `summary_rows`."""
    failed: int
    """Number of scenarios that could not be run to the end."""
    example: Dict[str, Any]
    """The row of the first failed scenario with the most frequent reason; empty if none failed."""
    problems: List[str]
    """The files that are left out, since a package is missing."""


class Sweep:
    """The scenarios of a file, and the folder that has their results.

    Args:
        settings: the content of the scenario file.
        folder: folder of the results; created if it does not exist.

    Attributes:
        scenarios: all of them.
        unused: the parameters that change nothing, by name.

    Raises:
        FlatlandError: a world or a controller cannot be used, or the folder not be written.
    """

    def __init__(self, settings: SweepSettings, folder: Path) -> None:
        self.settings = settings
        self.folder = folder
        self.scenarios = scenarios_of(settings)
        fingerprints = Fingerprints(settings)
        self.unused = fingerprints.unused
        self._fingerprints = {each.number: fingerprints.of(each) for each in self.scenarios}
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise FlatlandError(f"{folder}: cannot be made: {error.strerror}") from None
        self._journal = Journal(folder / JOURNAL)

    def close(self) -> None:
        """Closes the journal."""
        self._journal.close()

    def rest(self, with_failed: bool = False) -> List[Scenario]:
        """The scenarios that are not done yet.

        Args:
            with_failed: whether to include those that could not be run to the end.
        """
        results = [(each, self._journal.entries.get(key)) for each, key in self._keys()]
        return [
            scenario
            for scenario, result in results
            if result is None or (with_failed and result.error)
        ]

    def count_done(self) -> int:
        """The number of scenarios that are done, after an interruption of `run`."""
        self._journal.read_again()
        return len(self.scenarios) - len(self.rest())

    @property
    def damaged(self) -> List[int]:
        """The numbers of damaged lines of the journal; the scenarios in them are not done."""
        return self._journal.damaged

    @property
    def other_count(self) -> int:
        """Number of results in the folder of scenarios that are not, or no longer, in the sweep."""
        return len(set(self._journal.entries) - set(self._fingerprints.values()))

    @property
    def groups(self) -> Dict[str, str]:
        """The groups of worlds, by the names of those that belong to one."""
        return {each.name: each.group for each in self.settings.worlds if each.group}

    def run(self, scenarios: Iterable[Scenario], pool: Pool) -> Iterator[Result]:
        """Runs scenarios; each result is in the journal before it is yielded."""
        for done in pool.map(ScenarioRunner.run, scenarios):
            result = done.answer or Result({}, {}, done.failure)
            result = replace(result, seconds=done.seconds, attempts=done.attempts)
            self._journal.add(self._fingerprints[done.scenario.number], result)
            yield result

    def write(self, pool: Pool, pictures: int, metrics: Collection[str] = SUMMARISED) -> Written:
        """Writes the tables, the summary and the report of all scenarios, which must be done.

        Args:
            pool: pool that draws the pictures.
            pictures: greatest number of runs without success that are drawn.
            metrics: names in SUMMARISED, those of comparisons and of the tables and the figure for
                papers.

        Raises:
            FlatlandError: a file cannot be written.
        """
        results = [(each, self._journal.entries[key]) for each, key in self._keys()]
        rows = rows_of(results)
        summary = summary_rows(results)
        chosen = with_metrics(summary, metrics)
        table = table_of(rows)
        write_file(self.folder / "results.csv", csv_bytes(table))
        write_file(self.folder / "summary.csv", csv_bytes(table_of(summary)))
        write_file(self.folder / "timing.csv", csv_bytes(timing_table(results)))
        problems = [
            self._write_if_possible("results.parquet", lambda: parquet(table)),
            self._write_if_possible("summary.pdf", lambda: figure(chosen)),
        ]
        compared: List[Dict[str, Any]] = []

        def comparisons() -> bytes:
            compared.extend(comparison_rows(read_rows(self.folder), self.groups, metrics))
            return csv_bytes(table_of(compared))

        if len(self.settings.controllers) > 1:
            problems.append(self._write_if_possible("comparisons.csv", comparisons))
        write_file(self.folder / "summary.md", markdown_table(chosen, compared).encode())
        write_file(self.folder / "summary.tex", latex_table(chosen, compared).encode())
        numbers = _evenly([row["scenario"] for row in unsuccessful(rows)], pictures)
        to_draw = [self.scenarios[number - 1] for number in numbers]
        drawn = {done.scenario.number: done.answer or b"" for done in pool.map(draw, to_draw)}
        document = report_html(
            self.settings.file.name,
            f"flatland sweep {shlex.quote(self.settings.file.name)} --replay",
            summary,
            rows,
            [(rows[number - 1], drawn[number]) for number in numbers if drawn[number]],
        )
        write_file(self.folder / "report.html", document.encode("utf-8", "backslashreplace"))
        failed = [row for row in rows if row["status"] == "failed"]
        reasons = Counter(row["error"] for row in failed)
        example = max(failed, key=lambda row: reasons[row["error"]], default={})
        return Written(summary, len(failed), example, list(filter(None, problems)))

    def _write_if_possible(self, name: str, content: Callable[[], bytes]) -> str:
        """Writes a file that needs a package. Returns why it is not there; empty if it is.

        Raises:
            FlatlandError: the file cannot be written.
        """
        path = self.folder / name
        try:
            write_file(path, content())
        except MissingPackageError as error:
            if path.exists():  # of other results
                path.unlink()
            return f"no {name}: {error}"
        return ""

    def _keys(self) -> Iterator[Tuple[Scenario, str]]:
        """The scenarios with their fingerprints."""
        return ((each, self._fingerprints[each.number]) for each in self.scenarios)


def _evenly(numbers: List[int], count: int) -> List[int]:
    """At most `count` of some numbers, from all parts of the list."""
    if len(numbers) <= count:
        return numbers
    return [numbers[i * len(numbers) // count] for i in range(count)]


# The journal


class Journal:
    """The results so far, by the fingerprints of their scenarios, and the file that they are in.

    A line is written at once and in one piece when a scenario is done. The last one may be
    incomplete after a crash; it is then cut off, and its scenario is run again. So is that of a
    damaged line, as its checksum shows.

    Args:
        path: of the file; created if it does not exist.

    Attributes:
        entries: by fingerprint.
        damaged: the numbers of damaged lines.

    Raises:
        FlatlandError: the file cannot be written, is something else, or another sweep writes it.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        try:
            self._file = open(path, "a+b", buffering=0)  # noqa: SIM115
        except OSError as error:
            raise FlatlandError(f"{path}: cannot be written: {error.strerror}") from None
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            self.entries, self.damaged, end = _read(path)
            os.ftruncate(self._file.fileno(), end)
            if end == 0:
                self._write(_HEADER)
        except BlockingIOError:
            self.close()
            raise FlatlandError(f"{path.parent}: another sweep writes its results there") from None
        except BaseException:
            self.close()
            raise

    def add(self, fingerprint: str, result: Result) -> None:
        """Writes the result of a scenario."""
        content = json.dumps({"scenario": fingerprint, **asdict(result)}).encode()
        self._write(b"%s%s%d}\n" % (content[:-1], _CHECKSUM, zlib.crc32(content[:-1])))
        self.entries[fingerprint] = result

    def read_again(self) -> None:
        """Reads the entries from the file, after an interruption of `add` at any place."""
        self.entries = _read(self._path)[0]

    def close(self) -> None:
        """Closes the file."""
        self._file.close()

    def _write(self, line: bytes) -> None:
        try:
            if self._file.write(line) != len(line):
                raise OSError(0, "the disk is full")
        except OSError as error:
            raise FlatlandError(f"{self._path}: cannot be written: {error.strerror}") from None


def read_entries(path: Path) -> Dict[str, Result]:
    """The results of a journal, by fingerprint; none if there is no such file.

    Raises:
        FlatlandError: it is no journal.
    """
    return _read(path)[0] if path.exists() else {}


def _read(path: Path) -> Tuple[Dict[str, Result], List[int], int]:
    """The entries of a journal, its damaged lines, and the size of its complete lines [bytes].

    Raises:
        FlatlandError: it cannot be read, or is no journal.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise FlatlandError(f"{path}: cannot be read: {error.strerror}") from None
    *lines, _ = content.split(b"\n")
    entries: Dict[str, Result] = {}
    damaged = []
    for number, line in enumerate(lines, start=1):
        try:
            entries.update([_entry(line)])
        except (ValueError, KeyError, TypeError, RecursionError):
            if number > 1 or line + b"\n" != _HEADER:
                damaged.append(number)
    if not (entries or content.startswith(_HEADER) or _HEADER.startswith(content)):
        raise FlatlandError(f"{path}: is no journal of a sweep")
    return entries, damaged, content.rfind(b"\n") + 1


def _entry(line: bytes) -> Tuple[str, Result]:
    """The fingerprint and the result of a line; fails if it is damaged."""
    content, _, checksum = line.rpartition(_CHECKSUM)
    if checksum != b"%d}" % zlib.crc32(content):
        raise ValueError
    found = json.loads(content + b"}")
    return found.pop("scenario"), Result(**found)
