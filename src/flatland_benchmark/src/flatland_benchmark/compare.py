"""Comparison of two reports."""

import math
from typing import Iterator, List, NamedTuple

from flatland_benchmark.report import Figure, Report
from flatland_benchmark.tables import figure_title, row


class Change(NamedTuple):
    """A figure in two reports."""

    case: str
    name: str
    before: Figure
    after: Figure

    @property
    def ratio(self) -> float:
        """The median after, divided by the median before."""
        if self.before.median == 0.0:
            return 1.0 if self.after.median == 0.0 else math.inf
        return self.after.median / self.before.median

    @property
    def is_beyond_spread(self) -> bool:
        """True if all runs after are above all runs before, or all below."""
        (least_before, most_before), (least, most) = self.before.spread, self.after.spread
        return least > most_before or most < least_before


def changes(before: Report, after: Report) -> Iterator[Change]:
    """The figures that both reports have, in the order of the first."""
    for case, then in before.cases.items():
        now = after.cases[case].figures if case in after.cases else {}
        for name, figure in then.figures.items():
            if name in now and now[name].unit == figure.unit:
                yield Change(case, name, figure, now[name])


def comparison(before: Report, after: Report) -> str:
    """A table of both reports' medians."""
    lines = [comparison_head(before, after), *map(change_row, changes(before, after))]
    lines.extend(_only("before", before, after))
    lines.extend(_only("after", after, before))
    return "\n".join(lines) + "\n"


def comparison_head(before: Report, after: Report) -> str:
    """The first lines of the table."""
    lines = [f"before: {_origin(before)}", f"after:  {_origin(after)}"]
    if before.machine._replace(load=0.0) != after.machine._replace(load=0.0):
        lines.append("The machines differ: compare ratios within a report, not times.")
    heading = row("case", "figure", "before", "after", "ratio", "beyond spread")
    return "\n".join([*lines, "", heading])


def change_row(change: Change) -> str:
    """A line of the table."""
    return row(
        change.case,
        figure_title(change.name, change.before.unit),
        change.before.median,
        change.after.median,
        change.ratio,
        "yes" if change.is_beyond_spread else "no",
    )


def _origin(report: Report) -> str:
    return f"{report.version}, commit {report.commit or 'unknown'}, {report.date}"


def _only(when: str, report: Report, other: Report) -> List[str]:
    missing = [name for name in report.cases if name not in other.cases]
    return [f"only {when}: {', '.join(missing)}"] if missing else []
