"""Measures Flatland beside other simulators, in turns; `benchmarks/peers/run --help`."""

import argparse
import sys
from pathlib import Path
from typing import Dict, List, Optional

from comparison import TOLERANCE, Comparison, to_markdown, to_text
from processes import PeerError, Process
from scenario import Scenario
from simulators import FLATLAND, FLATLAND_SUBSTEPS, SIMULATORS, Case


def main(arguments: Optional[List[str]] = None) -> int:
    """Compares; returns an exit code: 1 if a simulator could not be measured."""
    options = _parser().parse_args(arguments)
    cases = [Case("room", number) for number in options.robots]
    cases += [Case("batch", size) for size in options.batch]
    cases += [Case("team", size) for size in options.team]
    cases += [Case("crowd", size) for size in options.crowd]
    simulators = (FLATLAND, FLATLAND_SUBSTEPS) if options.alone else SIMULATORS
    used = [each for each in simulators if any(case.suits(each) for case in cases)]
    comparison = Comparison(used, cases)
    processes: Dict[str, Process] = {}
    try:
        for simulator in comparison.simulators:
            processes[simulator.name] = Process(simulator)
            comparison.versions[simulator.name] = processes[simulator.name].versions
        for number in range(options.rounds):
            _measure_round(comparison, processes, number, options.seconds)
            _write(comparison, options)
    except KeyboardInterrupt:
        print("interrupted: what has been measured so far", file=sys.stderr)
    except PeerError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    finally:
        for process in processes.values():
            process.end()
    _report(comparison, options)
    return 0


def _measure_round(
    comparison: Comparison, processes: Dict[str, Process], number: int, seconds: float
) -> None:
    """Measures each case with all simulators, one after the other.

    Each round starts with another simulator, and has other places of discs and robots.
    """
    simulators = list(comparison.simulators)
    first = number % len(simulators)
    order = simulators[first:] + simulators[:first]
    for case in comparison.cases:
        for simulator in order:
            if not case.suits(simulator):
                continue
            process = processes[simulator.name]
            opened = process.ask(
                open=case.kind, variant=simulator.variant, robots=case.robots, seed=number + 1
            )
            if case.robots == 1 or case.kind == "batch":  # exact_ranges leaves out other robots
                layout = Scenario(case.robots, number + 1, rooms=case.robots)
                comparison.check(simulator, case, opened["ranges"], layout)
            comparison.add(simulator, case, process.ask(measure=seconds)["rate"])
            process.ask(close=True)
            print(".", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)


def _report(comparison: Comparison, options: argparse.Namespace) -> None:
    """Prints the results."""
    rows = comparison.rows()
    print(to_text(rows))
    print()
    for simulator in comparison.simulators:
        print(f"{comparison.title(simulator)}: {simulator.about}")
    print()
    print(f"ranges of first scans that are wrong by more than {1000 * TOLERANCE:g} mm:")
    for simulator in comparison.simulators:
        for case in comparison.cases:
            share = comparison.wrong_share(simulator, case)
            if share is not None:
                print(f"    {comparison.title(simulator)}, {case.title}: {100 * share:.2g} %")
    print()
    for target in comparison.targets():
        verdict = "met" if target["is_met"] else "MISSED"
        print(
            f"{target['case']}: {target['found']:.3g} times {target['peer']}, "
            f"asked {target['asked']:g}: {verdict}"
        )


def _write(comparison: Comparison, options: argparse.Namespace) -> None:
    """Writes the results into files; after each round, so that an interruption loses little."""
    if options.json is not None:
        options.json.write_text(comparison.to_json(), encoding="utf-8")
    if options.markdown is not None:
        options.markdown.write_text(to_markdown(comparison.rows()), encoding="utf-8")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="benchmarks/peers/run", description="Measures Flatland beside other simulators."
    )
    add = parser.add_argument
    add("--rounds", type=int, default=7, help="measurements of each case (default: 7)")
    add("--seconds", type=float, default=1.0, help="length of each (default: 1)")
    add("--robots", type=int, nargs="*", default=[1, 10, 100, 1000], help="in one room")
    add("--batch", type=int, nargs="*", default=[1024], help="sizes of batches (default: 1024)")
    add("--team", type=int, nargs="*", default=[], help="sizes of teams, 1,024 of each; with VMAS")
    add("--crowd", type=int, nargs="*", default=[], help="of agents with ORCA in one place")
    add("--alone", action="store_true", help="without the peers, which nothing is installed for")
    add("--json", type=Path, help="write all values into this file; see peers.schema.json")
    add("--markdown", type=Path, help="write the table into this file")
    return parser


if __name__ == "__main__":
    sys.exit(main())
