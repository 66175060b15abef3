"""Results of all simulators: figures, ratios and targets, as JSON and as tables."""

import json
import statistics
from dataclasses import dataclass, field
from typing import Any, Dict, List, Optional, Sequence, Tuple

import numpy as np

import scenario
from flatland_benchmark.machine import Machine, commit, now, version
from scenario import Scenario
from simulators import FLATLAND, TARGETS, Case, Simulator

SCHEMA = 1
TOLERANCE = 0.01
"""Tolerance of ranges [m]: ir-sim's discs are polygons of 64 corners."""


@dataclass
class Comparison:
    """Rates and scans of all simulators.

    Attributes:
        simulators: the simulators compared.
        cases: the cases measured.
        versions: of packages, by the name of the simulator.
        rates: robot-steps per second of processor time: one for each round, in their order.
        checks: for first scans, the number of wrong ranges and the number of all ranges.
    """

    simulators: Sequence[Simulator]
    cases: Sequence[Case]
    versions: Dict[str, Dict[str, str]] = field(default_factory=dict)
    rates: Dict[Tuple[str, str], List[float]] = field(default_factory=dict)
    checks: Dict[Tuple[str, str], Tuple[int, int]] = field(default_factory=dict)
    machine: Machine = field(default_factory=Machine.this)
    date: str = field(default_factory=now)

    def add(self, simulator: Simulator, case: Case, rate: float) -> None:
        """Notes a rate."""
        self.rates.setdefault((simulator.name, case.name), []).append(rate)

    def check(self, simulator: Simulator, case: Case, ranges: Any, layout: Scenario) -> None:
        """Compares ranges with exact ones."""
        found = np.array(ranges, dtype=float)
        is_right = np.abs(found - layout.exact_ranges()) <= TOLERANCE  # false for NaN
        wrong, count = self.checks.get((simulator.name, case.name), (0, 0))
        wrong += int(np.count_nonzero(~is_right))
        self.checks[simulator.name, case.name] = (wrong, count + found.size)

    def wrong_share(self, simulator: Simulator, case: Case) -> Optional[float]:
        """The share of ranges that are wrong; None if none was compared."""
        wrong, count = self.checks.get((simulator.name, case.name), (0, 0))
        return wrong / count if count else None

    def median(self, simulator: str, case: Case) -> Optional[float]:
        """The median of the rounds; None if it was not measured."""
        rates = self.rates.get((simulator, case.name))
        return statistics.median(rates) if rates else None

    def ratio(self, peer: str, case: Case) -> Optional[float]:
        """Flatland's rate divided by a peer's: the median of the rounds' ratios."""
        ours, others = (self.rates.get((name, case.name), []) for name in (FLATLAND.name, peer))
        ratios = [a / b for a, b in zip(ours, others)]
        return statistics.median(ratios) if ratios else None

    def targets(self) -> List[Dict[str, Any]]:
        """Each target with the measured ratios."""
        results = []
        for target in TARGETS:
            for case in self.cases:
                ratio = self.ratio(target.peer, case)
                if case.kind in target.kinds and ratio is not None:
                    results.append(
                        {
                            "peer": target.peer,
                            "case": case.name,
                            "asked": target.times,
                            "found": ratio,
                            "is_met": ratio >= target.times,
                        }
                    )
        return results

    def to_json(self) -> str:
        """The report as JSON; see peers.schema.json."""
        values = {
            "schema": SCHEMA,
            "date": self.date,
            "version": version(),
            "commit": commit(),
            "machine": self.machine._asdict(),
            "scenario": {
                "room": scenario.ROOM,
                "discs": scenario.DISCS,
                "beams": scenario.BEAMS,
                "range": scenario.RANGE,
                "step": scenario.STEP,
            },
            "simulators": {each.name: self._of(each) for each in self.simulators},
            "ratios": {
                each.name: self._ratios(each.name) for each in self.simulators if each.requirement
            },
            "targets": self.targets(),
        }
        return json.dumps(values, indent=2) + "\n"

    def _ratios(self, peer: str) -> Dict[str, float]:
        found = {case.name: self.ratio(peer, case) for case in self.cases}
        return {name: ratio for name, ratio in found.items() if ratio is not None}

    def _of(self, simulator: Simulator) -> Dict[str, Any]:
        """The results of one simulator, for the JSON report."""
        found = [(case, self.rates.get((simulator.name, case.name))) for case in self.cases]
        return {
            "about": simulator.about,
            "versions": self.versions.get(simulator.name, {}),
            "cases": {
                case.name: {
                    "unit": "robot-steps/s",
                    "median": statistics.median(rates),
                    "values": rates,
                    "wrong ranges": self.wrong_share(simulator, case),
                }
                for case, rates in found
                if rates
            },
        }

    def rows(self) -> List[List[str]]:
        """The cells of a table: its head, the rates, and the ratios."""
        rows = [["robot-steps per second of CPU time", *(case.title for case in self.cases)]]
        for simulator in self.simulators:
            cells = [self.median(simulator.name, case) for case in self.cases]
            rows.append([self.title(simulator), *(f"{c:,.0f}" if c else "-" for c in cells)])
        for simulator in self.simulators:
            if simulator.requirement:
                cells = [self.ratio(simulator.name, case) for case in self.cases]
                title = f"Flatland, times {simulator.name}"
                rows.append([title, *(_times(ratio) for ratio in cells)])
        return rows

    def title(self, simulator: Simulator) -> str:
        """Its name, with the version of a peer."""
        package = simulator.requirement.partition("==")[0]
        found = self.versions.get(simulator.name, {}).get(package)
        if found is None:
            return simulator.name
        return " ".join([package, found]) + simulator.name[len(package) :]


def _times(ratio: Optional[float]) -> str:
    if ratio is None:
        return "-"
    return f"{ratio:,.0f}" if ratio >= 10 else f"{ratio:.1f}"


def to_text(rows: List[List[str]]) -> str:
    """A table for a terminal."""
    widths = [max(map(len, column)) for column in zip(*rows)]
    lines = []
    for row in rows:
        cells = [row[0].ljust(widths[0])]
        cells += [cell.rjust(width) for cell, width in zip(row[1:], widths[1:])]
        lines.append("  ".join(cells))
    return "\n".join(lines)


def to_markdown(rows: List[List[str]]) -> str:
    """A table in Markdown."""
    head, *others = rows
    lines = [head, ["---", *("---:" for _ in head[1:])], *others]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)
