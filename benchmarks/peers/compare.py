"""Measures Flatland beside other simulators, in turns; `benchmarks/peers/run --help`."""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections import defaultdict
from pathlib import Path
from statistics import median
from typing import DefaultDict, Dict, List, NamedTuple, Optional, Tuple

from flatland_benchmark.tables import head, row
from simulators import FLATLAND, SIMULATORS, PeerError, Simulator, python_of

_WORKER = Path(__file__).resolve().with_name("worker.py")


class Case(NamedTuple):
    """Robots that are measured together: in one "Room", or in a "Batch" with a room for each."""

    kind: str
    robots: int

    @property
    def title(self) -> str:
        """The heading of its table column."""
        return f"{'robots' if self.kind == 'Room' else 'batch'} {self.robots}"

    @property
    def is_exact(self) -> bool:
        """True if no robot is in another one's view, so that exact ranges are known."""
        return self.robots == 1 or self.kind == "Batch"

    def suits(self, simulator: Simulator) -> bool:
        """True if a simulator can run this case."""
        is_batch = self.kind == "Batch"
        return simulator.has_batches if is_batch else self.robots <= simulator.most_robots


def measure(simulator: Simulator, case: Case, seed: int, seconds: float) -> Dict[str, float]:
    """Measures a simulator in a process of its own; see worker.py.

    Raises:
        PeerError: it cannot be installed, or has failed.
    """
    request = {
        "module": simulator.module,
        "kind": case.kind,
        "robots": case.robots,
        "seed": seed,
        "seconds": seconds,
        "options": simulator.options,
    }
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    environment["MPLBACKEND"] = "Agg"
    if simulator.requirement:
        environment.pop("PYTHONPATH", None)
    with tempfile.TemporaryDirectory(prefix="flatland_peers_") as folder:
        environment["TMPDIR"] = folder  # for world files, deleted with the folder
        answer = Path(folder, "answer.json")  # simulators and their libraries print
        command = [python_of(simulator), str(_WORKER), json.dumps(request), str(answer)]
        run = subprocess.run(command, env=environment, capture_output=True, text=True)
        if run.returncode:
            raise PeerError(f"{simulator.name} has failed:\n{run.stderr[-2000:]}")
        found: Dict[str, float] = json.loads(answer.read_text())
    return found


def main(arguments: Optional[List[str]] = None) -> int:
    """Compares; returns an exit code: 1 if a simulator could not be measured."""
    options = _parser().parse_args(arguments)
    cases = [Case("Room", number) for number in options.robots]
    cases += [Case("Batch", size) for size in options.batch]
    simulators = SIMULATORS[:2] if options.alone else SIMULATORS
    rates: DefaultDict[Tuple[str, Case], List[float]] = defaultdict(list)
    wrong: DefaultDict[str, List[float]] = defaultdict(list)
    try:
        for number in range(options.rounds):
            # Each round starts with another simulator, and has other places of discs and robots.
            first = number % len(simulators)
            for case in cases:
                for simulator in simulators[first:] + simulators[:first]:
                    if case.suits(simulator):
                        found = measure(simulator, case, number + 1, options.seconds)
                        rates[simulator.name, case].append(found["rate"])
                        if case.is_exact:
                            wrong[simulator.name].append(found["wrong"])
    except PeerError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    print("\n".join(table(cases, rates, wrong)))
    return 0


def table(
    cases: List[Case],
    rates: Dict[Tuple[str, Case], List[float]],
    wrong: Dict[str, List[float]],
) -> List[str]:
    """The rows: rates, how many times a peer's Flatland's are, and the share of wrong ranges.

    Args:
        cases: the cases, a column each.
        rates: of each round [robot-steps/s], by simulator and case.
        wrong: shares of wrong ranges, by simulator.
    """
    rows = [head("robot-steps per CPU second", *(case.title for case in cases), "wrong ranges [%]")]
    names = list(dict.fromkeys(name for name, _ in rates))
    for name in names:
        medians = (median(rates[name, case]) if (name, case) in rates else "" for case in cases)
        rows.append(row(name, *medians, 100.0 * median(wrong[name]) if name in wrong else ""))
    for name in names[1:]:
        pairs = [zip(rates[FLATLAND.name, case], rates.get((name, case), ())) for case in cases]
        ratios = [[ours / theirs for ours, theirs in each] for each in pairs]
        rows.append(row(f"times {name}", *(median(each) if each else "" for each in ratios), ""))
    return rows


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="benchmarks/peers/run", description="Measures Flatland beside other simulators."
    )
    add = parser.add_argument
    add("--rounds", type=int, default=7, help="measurements of each case (default: 7)")
    add("--seconds", type=float, default=1.0, help="length of each (default: 1)")
    add("--robots", type=int, nargs="*", default=[1, 10, 100, 1000], help="in one room")
    add("--batch", type=int, nargs="*", default=[1024], help="sizes of batches (default: 1024)")
    add("--alone", action="store_true", help="without the peers, which nothing is installed for")
    return parser


if __name__ == "__main__":
    sys.exit(main())
