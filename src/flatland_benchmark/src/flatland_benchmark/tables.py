"""Rows of the benchmark's tables."""

from typing import Union

from flatland_benchmark.report import CaseReport

_CASE, _FIGURE, _NUMBER = 26, 26, 14


def row(case: str, figure: str, *cells: Union[str, float]) -> str:
    """A line of a table; numbers have four digits, aligned on the right."""
    texts = [cell if isinstance(cell, str) else f"{cell:.4g}" for cell in cells]
    return f"{case:{_CASE}} {figure:{_FIGURE}}" + "".join(f"{text:>{_NUMBER}}" for text in texts)


def figure_title(name: str, unit: str) -> str:
    """A figure's name with its unit, if it has one."""
    return f"{name} [{unit}]" if unit else name


HEADER = row("case", "figure", "median", "least", "most")


def case_rows(name: str, case: CaseReport) -> str:
    """The rows of a case."""
    return "\n".join(
        row(name, figure_title(key, figure.unit), figure.median, *figure.spread)
        for key, figure in case.figures.items()
    )
