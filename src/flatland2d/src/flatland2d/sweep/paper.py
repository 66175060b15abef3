"""The summary of a sweep for a paper: a LaTeX and a Markdown table, and a figure."""

import io
from typing import Any, Dict, List, Mapping, Sequence, Tuple

from flatland2d.sweep.metrics import SUMMARISED
from flatland2d.sweep.report import summary_cells
from flatland_server.exceptions import MissingPackageError

_LATEX = {
    **{each: f"\\{each}" for each in "&%$#_{}"},
    "~": "\\textasciitilde{}",
    "^": "\\textasciicircum{}",
    "\\": "\\textbackslash{}",
}
_COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
"""M. Okabe and K. Ito, "Color universal design" (2008)."""
_PANEL = (2.3, 2.2)  # inches
_PANELS_IN_ROW = 3

Summary = Sequence[Mapping[str, Any]]
"""See `summary_rows`."""


def markdown_table(summary: Summary) -> str:
    """The summary as a table in Markdown."""
    heads, cells = _labelled(summary)
    lines = [heads, ["---"] * len(heads), *cells]
    return "".join(
        f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in line)} |\n" for line in lines
    )


def latex_table(summary: Summary) -> str:
    """The summary as a tabular of LaTeX, with the rules of the package booktabs."""
    heads, cells = _labelled(summary)
    columns = "".join("l" if name in ("world", "controller") else "r" for name in heads)
    head, *rows = (f"{' & '.join(map(_in_latex, line))} \\\\" for line in (heads, *cells))
    begin, end = f"\\begin{{tabular}}{{{columns}}}", "\\end{tabular}"
    lines = [begin, "\\toprule", head, "\\midrule", *rows, "\\bottomrule", end]
    return "\n".join(lines) + "\n"


def figure(summary: Summary) -> bytes:
    """The metrics of each controller with their confidence intervals, as PDF.

    A panel for each metric that has values, and a color for each world with its parameters.

    Raises:
        MissingPackageError: matplotlib is missing.
    """
    try:
        from matplotlib import rc_context
        from matplotlib.figure import Figure
    except ImportError as error:
        raise MissingPackageError(
            "the figure needs matplotlib: apt-get install python3-matplotlib, or pip install "
            f"'flatland2d[sweep]' ({str(error).splitlines()[0]})"
        ) from None
    metrics = [name for name in SUMMARISED if any(row[name] is not None for row in summary)]
    groups: Dict[str, List[Mapping[str, Any]]] = {}
    for row in summary:
        groups.setdefault(", ".join(_group(row)), []).append(row)
    controllers = list(dict.fromkeys(row["controller"] for row in summary))
    columns = min(_PANELS_IN_ROW, max(1, len(metrics)))
    rows = max(1, -(-len(metrics) // columns))
    with rc_context({"font.size": 8, "pdf.fonttype": 42, "text.parse_math": False}):
        drawn = Figure((columns * _PANEL[0], rows * _PANEL[1]), constrained_layout=True)
        panels = drawn.subplots(rows, columns, squeeze=False).flat
        for panel in panels[len(metrics) :]:
            panel.remove()
        for panel, name in zip(panels, metrics):
            for index, (label, group) in enumerate(groups.items()):
                shift = 0.6 * ((index + 0.5) / len(groups) - 0.5)
                places = [controllers.index(row["controller"]) + shift for row in group]
                _draw(panel, places, group, name, _COLORS[index % len(_COLORS)], label)
            panel.set_xticks(range(len(controllers)), controllers, rotation=30, ha="right")
            panel.set_xlim(-0.5, len(controllers) - 0.5)
            panel.set_ylabel(SUMMARISED[name].label)
            panel.grid(axis="y", linewidth=0.3)
        if len(groups) > 1:
            drawn.axes[0].legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), frameon=False)
        file = io.BytesIO()
        drawn.savefig(file, format="pdf", metadata={"CreationDate": None})
    return file.getvalue()


def _draw(
    panel: Any, places: List[float], rows: Summary, name: str, color: str, label: str
) -> None:
    """Draws the estimates of a metric, each with its interval."""
    found = [
        (place, row[name], row[f"{name}_low"], row[f"{name}_high"])
        for place, row in zip(places, rows)
        if row[name] is not None
    ]
    points = [(x, y, y - low, high - y) for x, y, low, high in found if low is not None]
    points += [(x, y, 0.0, 0.0) for x, y, low, _ in found if low is None]
    if points:
        x, y, below, above = zip(*points)
        panel.errorbar(
            x, y, yerr=(below, above), fmt="o", ms=3, capsize=2, lw=1, color=color, label=label
        )


def _group(row: Mapping[str, Any]) -> List[str]:
    """World and parameters of a row, such as "office" and "speed 0.5"."""
    names = list(row)[: list(row).index("scenarios")]
    return [
        str(row[name]) if name == "world" else f"{name} {row[name]}"
        for name in names
        if name != "controller"
    ]


def _labelled(summary: Summary) -> Tuple[List[str], List[List[str]]]:
    """The heads of the summary with units, and its cells; without a column of no failures."""
    heads, cells = summary_cells(summary)
    shown = [
        i
        for i, name in enumerate(heads)
        if name != "failed" or any(row["failed"] for row in summary)
    ]
    labels = [SUMMARISED[name].label if name in SUMMARISED else name for name in heads]
    return [labels[i] for i in shown], [[row[i] for i in shown] for row in cells]


def _in_latex(text: str) -> str:
    return "".join(_LATEX.get(each, each) for each in text)
