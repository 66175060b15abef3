"""Runs of cases, each in a process of its own: of this clone, and of another one in turn."""

import json
import math
import subprocess
import sys
from pathlib import Path
from statistics import median
from typing import List, Optional

from flatland_benchmark.case import Case, Figures
from flatland_server.config import find_world
from flatland_server.exceptions import FlatlandError


class Clone:
    """A clone to run cases of: its own cases, in its own workspace.

    Args:
        folder: of another clone, which is built; None: of this one.

    Raises:
        FlatlandError: the folder has no built clone.
    """

    def __init__(self, folder: Optional[Path] = None) -> None:
        self._shell: List[str] = []
        if folder is None:
            self._worlds = find_world("office").parents[1]
            return
        self._worlds = folder.resolve() / "src" / "flatland_server" / "worlds"
        setup = folder.resolve() / "devel" / "setup.bash"
        for path in (setup, self._worlds):
            if not path.exists():
                raise FlatlandError(f"--base: expected a clone that is built, found no {path}")
        self._shell = ["bash", "-c", 'source "$0" && exec "$@"', str(setup)]

    def run(self, case: Case) -> Figures:
        """Runs the case of this name once.

        Raises:
            FlatlandError: it failed; its error is on stderr.
        """
        command = [sys.executable, "-m", "flatland_benchmark", "--one", case.name]
        result = subprocess.run(
            [*self._shell, *command, str(self._worlds)], stdout=subprocess.PIPE, check=False
        )
        if result.returncode != 0:
            raise FlatlandError(f"the case {case.name} failed")
        figures: Figures = json.loads(result.stdout)
        return figures


def ratio(before: List[float], after: List[float]) -> float:
    """The median after, divided by the median before."""
    if median(before) == 0.0:
        return 1.0 if median(after) == 0.0 else math.inf
    return median(after) / median(before)


def is_beyond_spread(before: List[float], after: List[float]) -> bool:
    """True if all runs after are above all runs before, or all below."""
    return min(after) > max(before) or max(after) < min(before)
