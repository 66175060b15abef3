"""Measures Flatland beside other simulators, in turns; `benchmarks/peers/run --help`."""

import argparse
import sys
from collections import defaultdict
from statistics import median
from typing import DefaultDict, Dict, List, NamedTuple, Optional, Tuple

import numpy as np

from flatland_benchmark.tables import head, row
from processes import PeerError, Process, Simulator
from scenario import Scenario

TOLERANCE = 0.01
"""Tolerance of ranges [m]: ir-sim's discs are polygons of 64 corners."""

FLATLAND = Simulator("Flatland", "flatland_rooms", 1000, has_batches=True)
IRSIM = Simulator("ir-sim 2.12.0", "irsim_rooms", 100, requirement="ir-sim[all]==2.12.0")
SIMULATORS = (
    FLATLAND,
    FLATLAND._replace(name="Flatland, 20 x 5 ms", variant="20 x 5 ms"),
    IRSIM,
    IRSIM._replace(name="ir-sim, contact", variant="contact"),
    Simulator(
        "irsim-x 1.1.4",
        "irsim_rooms",
        1000,
        has_batches=True,
        requirement="irsim-x==1.1.4",
        flags="-mno-avx512f",  # with AVX-512, its batch leaves every other eight ranges undefined
    ),
    Simulator(
        "JalanSim 0.0.1",
        "jalansim_rooms",
        1,
        has_batches=True,
        requirement="jalansim==0.0.1 numpy",  # which it does not require itself
    ),
    Simulator(
        "JaxNav (jaxmarl 0.2.0)",
        "jaxnav_rooms",
        10,  # memory grows with the square of their number
        has_batches=True,
        requirement="jaxmarl==0.2.0",
    ),
)


class Case(NamedTuple):
    """Robots that are measured together: in one "room", or in a "batch" with a room for each."""

    kind: str
    robots: int

    @property
    def title(self) -> str:
        """The heading of its table column."""
        return f"{'robots' if self.kind == 'room' else 'batch'} {self.robots}"

    def suits(self, simulator: Simulator) -> bool:
        """True if a simulator can run this case."""
        is_batch = self.kind == "batch"
        return simulator.has_batches if is_batch else self.robots <= simulator.most_robots


def wrong_share(
    ranges: List[List[float]], exact: "np.ndarray[float, np.dtype[np.float64]]"
) -> float:
    """The share of ranges that are not the exact ones; NaN is wrong."""
    is_right = np.abs(np.array(ranges, dtype=float) - exact) <= TOLERANCE
    return float(np.mean(~is_right))


def main(arguments: Optional[List[str]] = None) -> int:
    """Compares; returns an exit code: 1 if a simulator could not be measured."""
    options = _parser().parse_args(arguments)
    cases = [Case("room", number) for number in options.robots]
    cases += [Case("batch", size) for size in options.batch]
    simulators = SIMULATORS[:2] if options.alone else SIMULATORS
    rates: DefaultDict[Tuple[str, Case], List[float]] = defaultdict(list)
    wrong: DefaultDict[str, List[float]] = defaultdict(list)
    processes: Dict[str, Process] = {}
    try:
        for simulator in simulators:
            processes[simulator.name] = Process(simulator)
        for number in range(options.rounds):
            # Each round starts with another simulator, and has other places of discs and robots.
            first = number % len(simulators)
            for case in cases:
                for simulator in simulators[first:] + simulators[:first]:
                    if not case.suits(simulator):
                        continue
                    found = processes[simulator.name].ask(
                        kind=case.kind,
                        variant=simulator.variant,
                        robots=case.robots,
                        seed=number + 1,
                        seconds=options.seconds,
                    )
                    if case.robots == 1 or case.kind == "batch":  # exact without other robots
                        layout = Scenario(case.robots, number + 1, rooms=case.robots)
                        share = wrong_share(found["ranges"], layout.exact_ranges())
                        wrong[simulator.name].append(share)
                    rates[simulator.name, case].append(found["rate"])
    except PeerError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    finally:
        for process in processes.values():
            process.end()
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
