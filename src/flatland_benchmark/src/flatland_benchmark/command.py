"""The command line: runs cases, and prints their figures, or beside those of another clone."""

import argparse
import fnmatch
import json
import sys
from pathlib import Path
from statistics import median
from typing import Dict, List, Optional

from flatland_benchmark.case import Case, Figures
from flatland_benchmark.cases import CASES
from flatland_benchmark.runs import Clone, is_beyond_spread, ratio
from flatland_benchmark.tables import head, row
from flatland_server.exceptions import FlatlandError, suggestion


def main(arguments: Optional[List[str]] = None) -> int:
    """Runs the command. Returns the exit code."""
    options = parser().parse_args(arguments)
    if options.one:
        name, worlds = options.one
        print(json.dumps(CASES[name].run(Path(worlds))))
        return 0
    if options.list:
        for case in CASES.values():
            print(f"{case.name:26} {case.description}")
        return 0
    try:
        if options.world:
            from flatland_benchmark.world_run import run_world

            return run_world(options.launch_files)
        return _run(select(options.cases), options)
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
    add("--json", type=Path, metavar="FILE", help="write the figures of all runs to a file, too")
    add("--base", type=Path, metavar="CLONE", help="run another clone in turn, and compare with it")
    # Added by benchmark.launch.
    add("--world", action="store_true", help=argparse.SUPPRESS)
    add("--launch-files", nargs="+", type=Path, default=[], help=argparse.SUPPRESS)
    add("--one", nargs=2, metavar=("CASE", "WORLDS"), help=argparse.SUPPRESS)
    return result


def _positive(text: str) -> int:
    if not text.isdigit() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"expected 1 or more, found {text}")
    return int(text)


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


def _run(cases: List[Case], options: argparse.Namespace) -> int:
    """Runs cases, and prints a table. Returns the exit code: 1 if a case failed."""
    clones = [Clone(options.base), Clone()] if options.base else [Clone()]
    measured: Dict[str, List[Figures]] = {}
    columns = ("before", "after", "ratio", "beyond spread")
    print(
        head("case", "figure", *(columns if options.base else ("median", "least", "most")), names=2)
    )
    for case in cases:
        try:
            # In turn, so that other programs affect both clones.
            runs = [[clone.run(case) for clone in clones] for _ in range(options.runs)]
        except FlatlandError as error:
            print(error, file=sys.stderr)
            continue
        of_clones = [list(each) for each in zip(*runs)]
        print("\n".join(_rows(case.name, of_clones)), flush=True)
        measured[case.name] = of_clones[-1]
        if options.json:  # after each case, in case of an interruption
            options.json.write_text(json.dumps(measured, indent=2) + "\n", encoding="utf-8")
    return 0 if len(measured) == len(cases) else 1


def _rows(case: str, of_clones: List[List[Figures]]) -> List[str]:
    """The rows of a case: of its runs, or of those of two clones."""
    rows = []
    for name in of_clones[-1][0]:
        if not all(name in runs[0] for runs in of_clones):
            continue  # the other clone does not measure it
        *before, values = [[run[name] for run in runs] for runs in of_clones]
        if before:
            is_beyond = "yes" if is_beyond_spread(before[0], values) else "no"
            change = (median(before[0]), median(values), ratio(before[0], values), is_beyond)
            rows.append(row(case, name, *change, names=2))
        else:
            rows.append(row(case, name, median(values), min(values), max(values), names=2))
    return rows
