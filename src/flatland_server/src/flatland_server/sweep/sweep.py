"""A sweep: runs the scenarios without a result, and writes tables, a summary and a report."""

import shlex
from collections import Counter
from pathlib import Path
from typing import Any, Dict, Iterable, Iterator, List, NamedTuple, Optional, Protocol

from flatland_server.exceptions import FlatlandError
from flatland_server.sweep.fingerprints import Fingerprints
from flatland_server.sweep.jobs import Job
from flatland_server.sweep.journal import Entry, Journal
from flatland_server.sweep.local_pool import Done
from flatland_server.sweep.report import report_html, unsuccessful
from flatland_server.sweep.runner import Result
from flatland_server.sweep.scenario import Scenario, scenarios_of
from flatland_server.sweep.settings import SweepSettings
from flatland_server.sweep.summary import rows_of, summary_rows, timing_table
from flatland_server.sweep.table import table_of, write_csv, write_file, write_parquet

JOURNAL = "journal.jsonl"


class Pool(Protocol):
    """The interface of `LocalPool` and `RayPool`."""

    def map(self, jobs: Iterable[Job]) -> Iterator[Done]:
        """Does jobs; yields each when it is done, in any order."""

    def close(self) -> None:
        """Stops all jobs at once."""


class Written(NamedTuple):
    """What was written."""

    summary: List[Dict[str, Any]]
    """See `summary_rows`."""
    failed: int
    """How many scenarios could not be run to the end."""
    example: Dict[str, Any]
    """The row of the first one with the most frequent reason; empty if there is none."""
    problem: str
    """Why there is no Parquet file; empty if there is one."""


class Sweep:
    """The scenarios of a file, and the folder that has their results.

    Args:
        settings: the content of the scenario file.
        folder: of the results; it is made if it is not there.

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

    def __enter__(self) -> "Sweep":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def rest(self, with_failed: bool = False) -> List[Scenario]:
        """The scenarios that are not done yet.

        Args:
            with_failed: whether those are among them that could not be run to the end.
        """
        return [
            scenario
            for scenario in self.scenarios
            if self._entry(scenario) is None
            or (with_failed and self._require_entry(scenario).result.error)
        ]

    @property
    def other_count(self) -> int:
        """How many results the folder has of scenarios that are not, or no longer, in the sweep."""
        return len(set(self._journal.entries) - set(self._fingerprints.values()))

    def run(self, scenarios: Iterable[Scenario], pool: Pool) -> Iterator[Result]:
        """Runs scenarios; each result is in the journal before it is yielded."""
        for done in pool.map(Job(scenario) for scenario in scenarios):
            assert isinstance(done.answer, Result)
            entry = Entry(done.answer, done.seconds, done.attempts)
            self._journal.add(self._fingerprints[done.job.scenario.number], entry)
            yield done.answer

    def result(self, scenario: Scenario) -> Optional[Result]:
        """The result of a scenario; None if it is not done yet."""
        entry = self._entry(scenario)
        return entry.result if entry is not None else None

    def write(self, pool: Pool, pictures: int) -> Written:
        """Writes the tables, the summary and the report of all scenarios, which must be done.

        Args:
            pool: draws the pictures.
            pictures: how many runs without success are drawn, at most.

        Raises:
            FlatlandError: a file cannot be written.
        """
        results = [(scenario, self._require_entry(scenario)) for scenario in self.scenarios]
        rows = rows_of(results)
        summary = summary_rows(results)
        table = table_of(rows)
        write_csv(self.folder / "results.csv", table)
        write_csv(self.folder / "summary.csv", table_of(summary))
        write_csv(self.folder / "timing.csv", timing_table(results))
        problem = ""
        try:
            write_parquet(self.folder / "results.parquet", table)
        except FlatlandError as error:
            problem = str(error)
            if (self.folder / "results.parquet").exists():  # of other results
                (self.folder / "results.parquet").unlink()
        chosen = _evenly([row["scenario"] for row in unsuccessful(rows)], pictures)
        drawn = self._draw(chosen, pool)
        document = report_html(
            self.settings.file.name,
            f"flatland sweep {shlex.quote(self.settings.file.name)} --replay",
            summary,
            rows,
            [(rows[number - 1], drawn[number]) for number in chosen if drawn[number]],
        )
        write_file(self.folder / "report.html", document.encode())
        failed = [row for row in rows if row["status"] == "failed"]
        reasons = Counter(row["error"] for row in failed)
        example = max(failed, key=lambda row: reasons[row["error"]], default={})
        return Written(summary, len(failed), example, problem)

    def _draw(self, numbers: List[int], pool: Pool) -> Dict[int, bytes]:
        """Pictures of scenarios, by number."""
        jobs = [Job(self.scenarios[number - 1], is_picture=True) for number in numbers]
        found: Dict[int, bytes] = {}
        for done in pool.map(jobs):
            assert isinstance(done.answer, bytes)
            found[done.job.scenario.number] = done.answer
        return found

    def _entry(self, scenario: Scenario) -> Optional[Entry]:
        return self._journal.entries.get(self._fingerprints[scenario.number])

    def _require_entry(self, scenario: Scenario) -> Entry:
        return self._journal.entries[self._fingerprints[scenario.number]]


def _evenly(numbers: List[int], count: int) -> List[int]:
    """At most `count` of some numbers, from all parts of the list."""
    if len(numbers) <= count:
        return numbers
    return [numbers[i * len(numbers) // count] for i in range(count)]
