"""The command line: runs cases, and prints, writes, compares and plots their figures."""

import argparse
import fnmatch
import json
import sys
from pathlib import Path
from typing import Dict, List, Optional

from flatland_benchmark.case import Case
from flatland_benchmark.cases import CASES
from flatland_benchmark.compare import change_row, changes, comparison, comparison_head
from flatland_benchmark.plots import draw, require_matplotlib
from flatland_benchmark.report import CaseReport, Report
from flatland_benchmark.runs import BaseClone, measure_in_turn, run_once
from flatland_benchmark.tables import HEADER, case_rows
from flatland_server.exceptions import FlatlandError, suggestion
from flatland_server.ros.launch_arguments import check_launch_arguments, parent_command_line


def main(arguments: Optional[List[str]] = None) -> int:
    """Runs the command. Returns the exit code."""
    options = parser().parse_args(arguments)
    if options.one:
        name, worlds = options.one
        print(json.dumps(CASES[name].run(Path(worlds))))
        return 0
    try:
        return _do(options)
    except FlatlandError as error:
        print(f"flatland_benchmark: {error}", file=sys.stderr)
        return 2


def parser() -> argparse.ArgumentParser:
    """The parser of the command line."""
    result = argparse.ArgumentParser(prog="flatland_benchmark", description="Measure Flatland.")
    add = result.add_argument
    add("cases", nargs="*", metavar="CASE", help="a name or a pattern as 'scan_*'; default: all")
    add("--list", action="store_true", help="list all cases")
    add("--runs", type=_positive, default=5, metavar="N", help="runs of each case (default 5)")
    add("--json", type=Path, metavar="FILE", help="write all values to a file, too")
    add("--plots", type=Path, metavar="DIR", help="write plots of the figures to a folder")
    add("--from", dest="source", type=Path, metavar="FILE", help="plot FILE; run nothing")
    add("--base", type=Path, metavar="CLONE", help="run another clone in turn, and compare with it")
    add("--compare", nargs=2, type=Path, metavar=("A", "B"), help="compare two files")
    # Added by benchmark.launch.
    add("--world", action="store_true", help=argparse.SUPPRESS)
    add("--launch-files", nargs="+", type=Path, default=[], help=argparse.SUPPRESS)
    add("--one", nargs=2, metavar=("CASE", "WORLDS"), help=argparse.SUPPRESS)
    return result


def _positive(text: str) -> int:
    if not text.isdigit() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"expected 1 or more, found {text}")
    return int(text)


def _do(options: argparse.Namespace) -> int:
    if options.launch_files:
        check_launch_arguments(options.launch_files, parent_command_line())
    if options.world:
        return _run_world(options)
    if options.list:
        for case in CASES.values():
            print(f"{case.name:26} {case.description}")
        return 0
    if options.compare:
        before, after = options.compare
        print(comparison(Report.read(before), Report.read(after)), end="")
        return 0
    if options.plots:
        require_matplotlib()  # before the cases run
    if options.base:
        return _run_beside(BaseClone(options.base), select(options.cases), options)
    failed: List[str] = []
    if options.source:
        report = Report.read(options.source)
    else:
        report = Report.begin()
        failed = _run(select(options.cases), report, options)
    if options.plots:
        for path in draw(report, options.plots):
            print(path)
    return 1 if failed else 0


def _run_world(options: argparse.Namespace) -> int:
    """Runs the world of the launch file's parameters. Returns the exit code."""
    if options.cases or options.plots:
        given = "cases" if options.cases else "plots"
        raise FlatlandError(f"expected world_path or {given}, found both")
    from flatland_benchmark.world_run import run_world

    return run_world(options.json)


def select(patterns: List[str]) -> List[Case]:
    """The cases of these names or patterns.

    Raises:
        FlatlandError: a pattern matches no case.
    """
    chosen: Dict[str, Case] = {}
    for pattern in patterns or ["*"]:
        names = fnmatch.filter(CASES, pattern)
        if not names:
            hint = suggestion(pattern, CASES)
            raise FlatlandError(f'unknown case "{pattern}"{hint}; --list shows all')
        chosen.update((name, CASES[name]) for name in names)
    return list(chosen.values())


def _run(cases: List[Case], report: Report, options: argparse.Namespace) -> List[str]:
    """Runs cases and adds their figures to the report. Returns the names of those that failed."""
    failed = []
    print(HEADER, flush=True)
    for case in cases:
        try:
            report.cases[case.name] = measure(case, options.runs)
        except FlatlandError as error:
            print(error, file=sys.stderr)
            failed.append(case.name)
            continue
        print(case_rows(case.name, report.cases[case.name]), flush=True)
        if options.json:  # after each case, in case of an interruption
            options.json.write_text(report.to_json(), encoding="utf-8")
    return failed


def measure(case: Case, runs: int) -> CaseReport:
    """Runs a case several times, each in a process of its own.

    Raises:
        FlatlandError: a run failed; its error is on stderr.
    """
    return CaseReport.of_runs(case.description, [run_once(case) for _ in range(runs)])


def _run_beside(base: BaseClone, cases: List[Case], options: argparse.Namespace) -> int:
    """Runs cases of both clones, and prints how each compares. Returns the exit code."""
    before, after = base.begin_report(), Report.begin()
    is_well = True
    print(comparison_head(before, after), flush=True)
    for case in cases:
        try:
            reports = measure_in_turn(case, options.runs, base.run_once, run_once)
        except FlatlandError as error:
            print(error, file=sys.stderr)
            is_well = False
            continue
        before.cases[case.name], after.cases[case.name] = reports
        for change in changes(before, after):
            if change.case == case.name:
                print(change_row(change), flush=True)
        if options.json:
            options.json.write_text(after.to_json(), encoding="utf-8")
    return 0 if is_well else 1
