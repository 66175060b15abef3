"""Runs of a case, each in a process of its own: of this clone, and of another one in turn."""

import json
import subprocess
import sys
from pathlib import Path
from typing import Callable, List, Tuple

from flatland_benchmark.case import Case, Figures
from flatland_benchmark.machine import Machine, commit_of, now, version_of
from flatland_benchmark.report import CaseReport, Report
from flatland_server.exceptions import FlatlandError

_ONE = ("-m", "flatland_benchmark", "--one")


def run_once(case: Case) -> Figures:
    """Runs a case of this clone.

    Raises:
        FlatlandError: it failed; its error is on stderr.
    """
    import rospkg

    worlds = Path(rospkg.RosPack().get_path("flatland_server")) / "worlds"
    return _figures([sys.executable, *_ONE, case.name, str(worlds)], case)


class BaseClone:
    """Another clone, to compare with: it is built, and its own cases run in its own workspace.

    Raises:
        FlatlandError: the folder has no built clone.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder.resolve()
        self._setup = self._folder / "devel" / "setup.bash"
        self._worlds = self._folder / "src" / "flatland_server" / "worlds"
        for path in (self._setup, self._worlds):
            if not path.exists():
                raise FlatlandError(f"--base: expected a clone that is built, found no {path}")

    def begin_report(self) -> Report:
        """An empty report of this machine and that clone."""
        package = self._folder / "src" / "flatland_server" / "package.xml"
        return Report(Machine.this(), version_of(package), commit_of(package), now())

    def run_once(self, case: Case) -> Figures:
        """Runs that clone's case of the same name.

        Raises:
            FlatlandError: it failed; its error is on stderr.
        """
        shell = ["bash", "-c", 'source "$0" && exec "$@"', str(self._setup)]
        return _figures([*shell, sys.executable, *_ONE, case.name, str(self._worlds)], case)


def measure_in_turn(
    case: Case, runs: int, run: Callable[[Case], Figures], other: Callable[[Case], Figures]
) -> Tuple[CaseReport, CaseReport]:
    """Runs a case several times in two ways, in turn, so that load on the machine affects both.

    Raises:
        FlatlandError: a run failed.
    """
    figures: Tuple[List[Figures], List[Figures]] = ([], [])
    for _ in range(runs):
        for each, way in zip(figures, (run, other)):
            each.append(way(case))
    first, second = (CaseReport.of_runs(case.description, each) for each in figures)
    return first, second


def _figures(command: List[str], case: Case) -> Figures:
    result = subprocess.run(command, stdout=subprocess.PIPE)
    if result.returncode != 0:
        raise FlatlandError(f"the case {case.name} failed")
    figures: Figures = json.loads(result.stdout)
    return figures
