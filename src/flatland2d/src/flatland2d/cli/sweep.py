"""flatland sweep: runs all scenarios of a file, or replays one of them."""

import argparse
import os
import signal
import sys
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Callable, List

from flatland2d.cli.arguments import INTERRUPTED, Subparsers, handled, not_negative, whole_from
from flatland2d.cli.sweep_progress import show_progress
from flatland2d.cli.sweep_replay import replay
from flatland2d.sweep.comparison import scipy_stats
from flatland2d.sweep.local_pool import LocalPool
from flatland2d.sweep.metrics import SUMMARISED
from flatland2d.sweep.ray_pool import RayPool
from flatland2d.sweep.regressions import junit, read_rows, verdicts
from flatland2d.sweep.report import summary_cells, text_table
from flatland2d.sweep.scenario_file import read_scenario_file
from flatland2d.sweep.sweep import JOURNAL, Pool, Sweep
from flatland2d.sweep.tables import write_file
from flatland_server.exceptions import counted, listed, unknown


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
