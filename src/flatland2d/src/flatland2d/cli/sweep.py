"""flatland sweep: runs all scenarios of a file, or replays one of them."""

import argparse
import os
import signal
import sys
import time
from contextlib import ExitStack, closing, contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Callable, Iterator, List

from flatland2d.cli.arguments import INTERRUPTED, Subparsers, handled, not_negative, whole_from
from flatland2d.cli.sweep_replay import replay
from flatland2d.sweep.comparison import junit, read_rows, scipy_stats, verdicts
from flatland2d.sweep.local_pool import LocalPool
from flatland2d.sweep.metrics import SUMMARISED
from flatland2d.sweep.ray_pool import RayPool
from flatland2d.sweep.report import summary_cells, text_table
from flatland2d.sweep.runner import Result
from flatland2d.sweep.scenario_file import read_scenario_file
from flatland2d.sweep.sweep import JOURNAL, Pool, Sweep
from flatland2d.sweep.tables import write_file
from flatland_server.exceptions import counted, listed, unknown

_LINE_PERIOD = 5.0
"""Real time between two lines of progress, where there is no terminal [s]."""


def add_parser(commands: Subparsers) -> None:
    """Adds the subcommand."""
    parser = commands.add_parser(
        "sweep",
        help="run many scenarios: worlds, controllers, parameters, seeds",
        description="Run all scenarios of a file, and write a table, a summary and a report. "
        "Ctrl-C ends it; the same command runs the rest.",
    )
    parser.add_argument("file", type=Path, metavar="FILE", help="the scenario file")
    parser.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="folder of the results (default: FILE_results, without the ending of FILE)",
    )
    parser.add_argument(
        "--jobs",
        type=whole_from(1),
        metavar="N",
        help="scenarios at a time (default: the number of CPUs)",
    )
    parser.add_argument(
        "--ray",
        metavar="ADDRESS",
        help='run on a Ray cluster, such as "auto" or ray://head:10001; "local" starts one here',
    )
    parser.add_argument(
        "--pictures",
        type=whole_from(0),
        default=20,
        metavar="N",
        help="runs without success that the report shows (default: %(default)s)",
    )
    parser.add_argument(
        "--metrics",
        type=_metrics,
        default=SUMMARISED,
        metavar="NAMES",
        help="the columns, separated by commas, that are compared and in the tables and the figure "
        "for papers (default: all); p-values are adjusted for these",
    )
    parser.add_argument(
        "--retry-failed",
        action="store_true",
        help="run those again, too, that could not be run to the end",
    )
    parser.add_argument(
        "--restart", action="store_true", help="forget the results that the folder has"
    )
    parser.add_argument(
        "--baseline",
        type=Path,
        metavar="RESULTS",
        help="results of a former sweep (its folder or its results.csv): the exit code is 1 if "
        "these are significantly worse",
    )
    parser.add_argument(
        "--tolerance",
        type=not_negative,
        default=0.01,
        metavar="FRACTION",
        help="with --baseline: smaller changes for the worse are none (default: %(default)s)",
    )
    parser.add_argument(
        "--no-progress", dest="progress", action="store_false", help="show no progress"
    )
    parser.add_argument(
        "--replay", type=whole_from(1), metavar="ID", help="run one scenario alone, by its number"
    )
    parser.add_argument(
        "--view", action="store_true", help="with --replay: show the run in the browser"
    )
    parser.add_argument(
        "--record",
        metavar="BAG",
        help="with --replay: record messages: .bag for ROS, .mcap for Foxglove",
    )
    parser.set_defaults(execute=_execute, parser=parser)


def _metrics(text: str) -> List[str]:
    """The names of metrics."""
    names = text.split(",")
    for name in names:
        if name not in SUMMARISED:
            raise argparse.ArgumentTypeError(unknown("there is no metric", name, SUMMARISED))
    return names


def _execute(options: argparse.Namespace) -> int:
    if options.replay is None and (options.view or options.record):
        options.parser.error("--view and --record are of --replay")
    settings = read_scenario_file(options.file)
    folder = options.out or Path(f"{options.file.stem}_results")
    if options.replay is not None:
        with handled(signal.default_int_handler):
            return replay(settings, options.replay, folder, options.view, options.record)
    if options.baseline is not None:  # before the scenarios are run
        scipy_stats()
        options.baseline = read_rows(options.baseline)
    if options.restart and (folder / JOURNAL).exists():
        (folder / JOURNAL).unlink()
    with ExitStack() as stack:
        stack.enter_context(handled(signal.default_int_handler))
        sweep = stack.enter_context(closing(Sweep(settings, folder)))
        try:
            return _run(sweep, options, stack)
        except KeyboardInterrupt:
            print(
                f"interrupted: {sweep.count_done()} of {len(sweep.scenarios)} scenarios are done; "
                "the same command runs the rest",
                file=sys.stderr,
            )
            return INTERRUPTED


def _run(sweep: Sweep, options: argparse.Namespace, stack: ExitStack) -> int:
    """Runs the rest of a sweep, and writes the results."""
    rest = sweep.rest(options.retry_failed)
    done = len(sweep.scenarios) - len(rest)
    for name in sweep.unused:
        where = (
            "no file of the worlds reads it" if name.startswith("/") else "there is no controller"
        )
        print(f'the parameter "{name}" changes nothing: {where}', file=sys.stderr)
    if sweep.damaged:
        lines = listed([str(number) for number in sweep.damaged])
        print(
            f"{sweep.folder / JOURNAL}: expected a result in each line, found damaged lines: "
            f"{lines}; they are left out, and their scenarios run again",
            file=sys.stderr,
        )
    if sweep.other_count:
        print(
            f"{options.file} or a file that it names has changed: {sweep.other_count} results in "
            f"{sweep.folder} are of other scenarios and left out",
            file=sys.stderr,
        )
    if done:
        print(f"{done} of {len(sweep.scenarios)} scenarios are done already", file=sys.stderr)
    progress = stack.enter_context(show_progress(len(sweep.scenarios), done, options.progress))
    pool = stack.enter_context(closing(_pool(sweep, options, progress.say)))
    for result in sweep.run(rest, pool):
        progress.count(result)
    progress.end()
    written = sweep.write(pool, options.pictures, options.metrics)
    print(text_table(*summary_cells(written.summary, is_brief=True)))
    print(
        f"results in {sweep.folder}, with more metrics: results.csv, summary.csv, report.html ..."
    )
    for problem in written.problems:
        print(problem, file=sys.stderr)
    if written.failed:
        print(
            f"{written.failed} of {len(sweep.scenarios)} scenarios failed to run to the end, most "
            f"often by: {written.example['error']}\n"
            f"--replay {written.example['scenario']} shows it; results.csv has all reasons (error)",
            file=sys.stderr,
        )
    return 1 if _report_regressions(options, sweep) or written.failed else 0


def _report_regressions(options: argparse.Namespace, sweep: Sweep) -> bool:
    """Compares the results with the baseline, if there is one; returns whether they are worse."""
    if options.baseline is None:
        return False
    rows = read_rows(sweep.folder)
    found = verdicts(rows, options.baseline, options.tolerance, sweep.groups)
    write_file(sweep.folder / "regressions.xml", junit(options.file.name, found))
    worse = [each for each in found if each.is_regression]
    for each in worse:
        print(f"worse than the baseline: {each}", file=sys.stderr)
    if not worse:
        pairs = max(each.result.pairs for each in found)
        print(f"not worse than the baseline, in up to {counted(pairs, 'pair')} of runs")
    return bool(worse)


def _pool(sweep: Sweep, options: argparse.Namespace, report: Callable[[str], None]) -> Pool:
    """The workers that run the scenarios."""
    if options.ray is not None:
        return RayPool(sweep.settings, options.ray, options.jobs, report, sweep.folder)
    return LocalPool(sweep.settings, options.jobs or len(os.sched_getaffinity(0)), report)


class Progress:
    """Counts scenarios, and shows their number in a bar of tqdm or in lines, or not at all.

    Lines come at the beginning, from time to time, and at the end.

    Args:
        total: number of scenarios.
        done: number of scenarios that are done already.
        is_shown: whether anything but messages is shown.
        bar: of tqdm; None without one.
    """

    def __init__(self, total: int, done: int, is_shown: bool, bar: Any = None) -> None:
        self._total, self._done, self._first = total, done, done + 1
        self._has_lines, self._bar = is_shown and bar is None, bar
        self._succeeded = self._failed = 0
        self._begin = self._last = self._first_time = time.monotonic()
        self._printed = -1

    def count(self, result: Result) -> None:
        """Notes a scenario that is done."""
        self._done += 1
        self._succeeded += result.row.get("success") is True
        self._failed += bool(result.error)
        now, is_first = time.monotonic(), self._done == self._first
        if is_first:
            self._first_time = now
        if self._bar is not None:
            self._bar.set_postfix_str(self._state, refresh=False)
            self._bar.update()
        elif self._has_lines and (is_first or now - self._last >= _LINE_PERIOD):
            self._last = now
            self._print()

    def say(self, message: str) -> None:
        """Shows a sentence."""
        if self._bar is not None:
            self._bar.write(message, file=sys.stderr)
        else:
            print(message, file=sys.stderr, flush=True)

    def end(self) -> None:
        """Shows the last state."""
        if self._has_lines and self._done > self._printed:
            self._print()

    @property
    def _state(self) -> str:
        failed = f", {self._failed} failed" if self._failed else ""
        return f"{self._succeeded} with success{failed}"

    def _print(self) -> None:
        self._printed = self._done
        now = time.monotonic()
        rest, since_first = self._total - self._done, self._done - self._first
        left = ""
        if rest and since_first > 0:  # workers take a while to start: the first one says little
            left = f", {(now - self._first_time) * rest / since_first:.0f} s left"
        elapsed = now - self._begin
        self.say(f"{self._done} of {self._total} scenarios, {self._state}, {elapsed:.0f} s{left}")


@contextmanager
def show_progress(total: int, done: int, is_wanted: bool) -> Iterator[Progress]:
    """Shows the progress of a sweep: a bar if standard error is a terminal and tqdm is installed.

    Args:
        total: number of scenarios.
        done: number of scenarios that are done already.
        is_wanted: whether anything is shown.
    """
    if is_wanted and sys.stderr.isatty() and find_spec("tqdm"):
        import tqdm

        with tqdm.tqdm(total=total, initial=done, unit=" scenarios") as bar:
            yield Progress(total, done, is_wanted, bar)
    else:
        yield Progress(total, done, is_wanted)
