"""A report: what was measured, where and when. benchmark.schema.json describes its JSON form."""

import json
import re
import statistics
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Dict, List, NamedTuple, Optional, Tuple

from flatland_benchmark.machine import Machine, commit, now, version
from flatland_server.exceptions import FlatlandError

SCHEMA_VERSION = 1
"""Increased whenever older files cannot be read the same way."""

_WITH_UNIT = re.compile(r"(.*) \[(.*)\]")


class Figure(NamedTuple):
    """A quantity, measured once per run."""

    unit: str  # empty for a ratio or a count
    values: Tuple[float, ...]  # one for each run

    @property
    def median(self) -> float:
        """The median of the runs."""
        return statistics.median(self.values)

    @property
    def spread(self) -> Tuple[float, float]:
        """The least and the greatest value."""
        return min(self.values), max(self.values)


@dataclass(frozen=True)
class CaseReport:
    """The figures of a case, by name."""

    description: str
    figures: Dict[str, Figure]

    @classmethod
    def of_runs(cls, description: str, runs: List[Dict[str, float]]) -> "CaseReport":
        """Collects the runs' figures; their names end in a unit in brackets."""
        figures = {}
        for key in runs[0]:
            match = _WITH_UNIT.fullmatch(key)
            name, unit = match.groups() if match else (key, "")
            figures[name] = Figure(unit, tuple(run[key] for run in runs))
        return cls(description, figures)


@dataclass(frozen=True)
class Report:
    """The results of one run of the benchmark."""

    machine: Machine
    version: str
    commit: Optional[str]
    date: str
    cases: Dict[str, CaseReport] = field(default_factory=dict)

    @classmethod
    def begin(cls) -> "Report":
        """An empty report for this machine, version and time."""
        return cls(Machine.this(), version(), commit(), now())

    def to_json(self) -> str:
        """The report as JSON."""
        values = {
            "schema": SCHEMA_VERSION,
            "date": self.date,
            "version": self.version,
            "commit": self.commit,
            "machine": self.machine._asdict(),
            "cases": {
                name: {
                    "description": case.description,
                    "figures": {key: _to_dict(figure) for key, figure in case.figures.items()},
                }
                for name, case in self.cases.items()
            },
        }
        return json.dumps(values, indent=2) + "\n"

    @classmethod
    def read(cls, path: Path) -> "Report":
        """Reads a report from a file.

        Raises:
            FlatlandError: the file cannot be read, or is not a report.
        """
        try:
            values: Any = json.loads(path.read_text(encoding="utf-8"))
            if values["schema"] != SCHEMA_VERSION:
                raise FlatlandError(
                    f"{path}: expected schema {SCHEMA_VERSION}, found {values['schema']}"
                )
            cases = {
                name: CaseReport(
                    case["description"],
                    {
                        key: Figure(figure["unit"], tuple(figure["values"]))
                        for key, figure in case["figures"].items()
                    },
                )
                for name, case in values["cases"].items()
            }
            machine = Machine(**values["machine"])
            return cls(machine, values["version"], values["commit"], values["date"], cases)
        except OSError as error:
            raise FlatlandError(f"{path}: cannot be read: {error.strerror}") from None
        except (ValueError, KeyError, TypeError, AttributeError):
            raise FlatlandError(f"{path}: is not a report of flatland_benchmark") from None


def _to_dict(figure: Figure) -> Dict[str, Any]:
    return {
        "unit": figure.unit,
        "median": figure.median,
        "spread": list(figure.spread),
        "values": list(figure.values),
    }
