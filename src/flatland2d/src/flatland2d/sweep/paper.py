"""The summary of a sweep for a paper: a LaTeX and a Markdown table, and a figure."""

import io
import textwrap
from itertools import zip_longest
from typing import (
    Any,
    Collection,
    Dict,
    Iterator,
    List,
    Mapping,
    NamedTuple,
    Optional,
    Sequence,
    Tuple,
)

from flatland2d.sweep.comparison import comparable
from flatland2d.sweep.metrics import SUMMARISED, Metric
from flatland2d.sweep.run import ESTIMATE_ENDS
from flatland2d.sweep.tables import one_line, text_of
from flatland_server.exceptions import needed_module, pip_install

_LATEX = {
    **{each: f"\\{each}" for each in "&%$#_{}"},
    "<": "$<$",
    "\N{NO-BREAK SPACE}": "~",
    "~": "\\textasciitilde{}",
    "^": "\\textasciicircum{}",
    "\\": "\\textbackslash{}",
    "³": "\\textsuperscript{3}",
    "\N{MINUS SIGN}": "$-$",
    "\N{UPWARDS ARROW}": "$\\uparrow$",
    "\N{DOWNWARDS ARROW}": "$\\downarrow$",
}
_COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
"""M. Okabe and K. Ito, "Color universal design" (2008)."""
_PANEL = (1.75, 1.65)  # inches
_PANELS_IN_ROW = 4  # as wide as the text of a page with two columns
_MARKERS = "osD^vP*"
_LETTERS = 20
"""In a line beside a panel."""
_NARROW = 16
"""In a line of a table of LaTeX; beside three controllers in one of two columns."""
_LOWEST = -0.04
"""Lower end of an axis relative to its upper end: a mark at 0 is whole."""
_LEVEL = 0.05
"""Of p-values: a controller with a smaller one is worse than the best."""

Summary = Sequence[Mapping[str, Any]]
"""See `summary_rows`."""

Comparisons = Sequence[Mapping[str, Any]]
"""See `comparison_rows`."""


class _Cell(NamedTuple):
    """A metric of a controller.

    Attributes:
        value: as text; empty if there is none.
        interval: in brackets, or empty.
        p: such as "p = 0.03", or empty.
        is_bold: whether it is the best, or not significantly worse.
    """

    value: str
    interval: str = ""
    p: str = ""
    is_bold: bool = False


def with_metrics(summary: Summary, metrics: Collection[str]) -> Summary:
    """The summary without the other metrics of SUMMARISED."""
    others = set(SUMMARISED).difference(metrics)
    left_out = {f"{name}{end}" for name in others for end in ("", *ESTIMATE_ENDS)}
    return [{k: value for k, value in row.items() if k not in left_out} for row in summary]


def markdown_table(summary: Summary, comparisons: Comparisons = ()) -> str:
    """The summary as a table in Markdown: a row for each world and metric.

    Args:
        summary: summary rows of all worlds and controllers.
        comparisons: see `latex_table`.
    """
    heads = ["world", "metric", *_controllers(summary)]
    lines = [heads, ["---"] * len(heads)]
    for title, rows in _groups(summary).items():
        for label, cells in _lines(rows, heads[2:], summary, comparisons):
            texts = [f"**{each.value}**" if each.is_bold else each.value for each in cells]
            ends = [f" {cell.interval}" * bool(cell.interval) for cell in cells]
            values = [f", {cell.p}" * bool(cell.p) for cell in cells]
            lines.append([title, label, *map("".join, zip(texts, ends, values))])
    return "".join(f"| {' | '.join(map(_in_markdown, line))} |\n" for line in lines)


def latex_table(summary: Summary, comparisons: Comparisons = ()) -> str:
    """The summary as a tabular of LaTeX, with the rules of the package booktabs.

    A column for each controller, and a block of metrics for each world with its parameters. An
    interval is below its value, and a p-value below that, so that three controllers fit into one
    of two columns of a page.

    Args:
        summary: summary rows of all worlds and controllers.
        comparisons: of the controllers; those that are significantly worse than the best one are
            told from the others, which are bold.
    """
    controllers = _controllers(summary)
    lines = [
        "% Needs booktabs. In a column: \\footnotesize, and \\setlength{\\tabcolsep}{4pt}.",
        "% Intervals of 95 % confidence: Wilson's score interval for rates, Student's for means.",
        "% Times and paths to the goal, and fractions, are those of the runs that have reached it.",
    ]
    if comparisons:
        lines += [
            "% p: of the same tasks as the best controller's, by McNemar's exact test for rates",
            "% and Wilcoxon's signed-rank test for means, adjusted by Holm's method for the table.",
            f"% Bold: the best and those that are not worse at p < {_LEVEL:g}, where any is worse.",
        ]
    lines += [
        f"\\begin{{tabular}}{{@{{}}l{'r' * len(controllers)}@{{}}}}",
        "\\toprule",
        _latex_row(["", *map(_in_latex, controllers)]),
    ]
    for title, rows in _groups(summary).items():
        width = len(controllers) + 1
        lines += [
            "\\midrule",
            f"\\multicolumn{{{width}}}{{@{{}}l@{{}}}}{{\\textit{{{_in_latex(title)}}}}} \\\\",
        ]
        for label, cells in _lines(rows, controllers, summary, comparisons):
            texts = [_in_latex(each.value) for each in cells]
            below = [[each.interval for each in cells], [each.p for each in cells]]
            values = [
                [f"\\textbf{{{k}}}" if each.is_bold else k for k, each in zip(texts, cells)],
                *(map(_small, each) for each in below if any(each)),
            ]
            words = map(_in_latex, textwrap.wrap(_unbroken(label), _NARROW))
            blank = [""] * len(cells)
            for word, row in zip_longest(words, values):
                lines.append(_latex_row([word or "", *(row or blank)]))
            lines.append("\\addlinespace[2pt]")
        lines.pop()
    return "\n".join([*lines, "\\bottomrule", "\\end{tabular}"]) + "\n"


def figure(summary: Summary) -> bytes:
    """The metrics of each controller with their confidence intervals, as PDF.

    A panel for each metric that has values other than 0, from 0; a color for each world with its
    parameters.

    Raises:
        MissingPackageError: matplotlib is missing.
    """
    install = f"apt-get install python3-matplotlib, or {pip_install('sweep')}"
    needed_module("matplotlib", "the figure needs matplotlib", install)
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    metrics = [name for name in SUMMARISED if any(row.get(name) for row in summary)]
    groups, controllers = _groups(summary), _controllers(summary)
    columns = min(_PANELS_IN_ROW, max(1, len(metrics)))
    rows = max(1, -(-len(metrics) // columns))
    with rc_context({"font.size": 7, "pdf.fonttype": 42, "text.parse_math": False}):
        drawn = Figure((columns * _PANEL[0], rows * _PANEL[1]), constrained_layout=True)
        panels = drawn.subplots(rows, columns, squeeze=False).flat
        for panel in panels[len(metrics) :]:
            panel.remove()
        for panel, name in zip(panels, metrics):
            for index, (label, group) in enumerate(groups.items()):
                shift = 0.6 * ((index + 0.5) / len(groups) - 0.5)
                places = [controllers.index(row["controller"]) + shift for row in group]
                _draw(panel, places, group, name, index % len(_COLORS), label)
            panel.set_xticks(range(len(controllers)), controllers, rotation=30, ha="right")
            panel.set_xlim(-0.5, len(controllers) - 0.5)
            panel.set_ylabel(textwrap.fill(_unbroken(_name(name)), _LETTERS))
            top = 100.0 if SUMMARISED[name].is_rate else panel.get_ylim()[1]
            panel.set_ylim(_LOWEST * top, (1.0 - _LOWEST) * top)
            panel.grid(axis="y", linewidth=0.3)
        if len(groups) > 1 and metrics:
            drawn.axes[0].legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), frameon=False)
        file = io.BytesIO()
        drawn.savefig(file, format="pdf", metadata={"CreationDate": None})
    return file.getvalue()


def _draw(
    panel: Any, places: List[float], rows: Summary, name: str, style: int, label: str
) -> None:
    """Draws the estimates of a metric, each with its interval."""
    found = [(place, *_ends(name, row)) for place, row in zip(places, rows)]
    points = [
        (x, y, 0.0 if low is None else y - low, 0.0 if high is None else high - y)
        for x, y, low, high in found
        if y is not None
    ]
    if points:
        x, y, below, above = zip(*points)
        look = {"fmt": _MARKERS[style], "color": _COLORS[style]}
        panel.errorbar(x, y, yerr=(below, above), ms=3, capsize=2, lw=1, label=label, **look)


def _controllers(summary: Summary) -> List[str]:
    return list(dict.fromkeys(str(row["controller"]) for row in summary))


def _groups(summary: Summary) -> Dict[str, List[Mapping[str, Any]]]:
    """The rows by world and parameters, such as "office, speed 0.5"."""
    groups: Dict[str, List[Mapping[str, Any]]] = {}
    for row in summary:
        parts = [
            f"{row[name]}" if name == "world" else f"{name} {row[name]}"
            for name in _task_names(row)
        ]
        groups.setdefault(", ".join(parts), []).append(row)
    return groups


def _task_names(row: Mapping[str, Any]) -> List[str]:
    """The columns of world and parameters."""
    names = list(row)
    return [name for name in names[: names.index("scenarios")] if name != "controller"]


def _lines(
    rows: Summary, controllers: Sequence[str], summary: Summary, comparisons: Comparisons
) -> Iterator[Tuple[str, List[_Cell]]]:
    """The numbers of runs, and the metrics that have values: a label, and a cell by controller.

    A metric has equally many decimals in the whole summary.
    """
    by_controller = {str(row["controller"]): row for row in rows}
    found = [by_controller.get(name) for name in controllers]
    yield "runs", [_Cell(str(row["scenarios"]) if row else "") for row in found]
    if any(row["failed"] for row in rows):
        yield "failed to run", [_Cell(str(row["failed"]) if row else "") for row in found]
    compared = _compared(rows[0], comparisons)
    for name in rows[0]:
        if f"{name}_low" in rows[0] and any(row[name] is not None for row in rows):
            form = _form(name, summary)
            cells = [_cell(name, row, form) if row else _Cell("") for row in found]
            yield _label(name), _with_p_values(cells, found, name, compared)


def _compared(row: Mapping[str, Any], comparisons: Comparisons) -> Dict[Tuple[str, ...], Any]:
    """The comparisons of the world and parameters of a row: by metric and both controllers."""
    names = _task_names(row)
    task = [comparable(text_of(row[name])) for name in names]
    keys = ("metric", "controller", "against")
    return {
        tuple(each[key] for key in keys): each
        for each in comparisons
        if [each[name] for name in names] == task
    }


def _with_p_values(
    cells: List[_Cell],
    rows: Sequence[Optional[Mapping[str, Any]]],
    name: str,
    compared: Mapping[Tuple[str, ...], Any],
) -> List[_Cell]:
    """The cells of a metric with p-values against the best one; bold if another one is worse."""
    better = SUMMARISED[name].better if name in SUMMARISED else 0
    values = {i: better * row[name] for i, row in enumerate(rows) if row and row[name] is not None}
    if not better or not values:
        return cells
    best = max(values, key=values.__getitem__)
    worse = set()
    found = list(cells)
    for i in values:
        names = [str(row["controller"]) for row in (rows[i], rows[best]) if row]
        sign = better
        result = compared.get((name, *names))
        if result is None:
            sign, result = -better, compared.get((name, *names[::-1]))
        if result is not None:
            p = result["p"]
            found[i] = cells[i]._replace(p="p < 0.001" if p < 0.001 else f"p = {p:.3f}")
            if p < _LEVEL and sign * (result["mean"] - result["other_mean"]) < 0.0:
                worse.add(i)
    bold = set(values).difference(worse) if worse else set()
    return [cell._replace(is_bold=i in bold) for i, cell in enumerate(found)]


def _name(metric: str) -> str:
    """A metric with its unit."""
    found = SUMMARISED.get(metric, Metric(metric, 0))
    return f"{found.label} [%]" if found.is_rate else found.label


def _label(metric: str) -> str:
    """The same with an arrow: up if more is better, down if less is."""
    better = SUMMARISED[metric].better if metric in SUMMARISED else 0
    return _name(metric) + ("", " \N{UPWARDS ARROW}", " \N{DOWNWARDS ARROW}")[better]


def _unbroken(label: str) -> str:
    """A label in which no line ends before its unit or its arrow."""
    for each in "[\N{UPWARDS ARROW}\N{DOWNWARDS ARROW}":
        label = label.replace(f" {each}", f"\N{NO-BREAK SPACE}{each}")
    return label


def _ends(name: str, row: Mapping[str, Any]) -> Tuple[Optional[float], ...]:
    """The value of a metric and the ends of its interval; of a rate in per cent."""
    scale = 100.0 if name in SUMMARISED and SUMMARISED[name].is_rate else 1.0
    values = (row.get(f"{name}{end}") for end in ("", "_low", "_high"))
    return tuple(None if value is None else scale * value for value in values)


def _form(name: str, rows: Summary) -> str:
    """The format of a metric in these rows."""
    if name in SUMMARISED and SUMMARISED[name].is_rate:
        return ".1f"
    most = max(abs(value) for row in rows for value in _ends(name, row) if value is not None)
    if most and not 0.01 <= most < 1e6:
        return ".3g"
    return ".1f" if most >= 10.0 or not most else ".2f" if most >= 1.0 else ".3f"


def _cell(name: str, row: Mapping[str, Any], form: str) -> _Cell:
    """A metric with its interval."""

    def text(number: float) -> str:
        shown = format(number, form)
        return (shown if float(shown) else format(0.0, form)).replace("-", "\N{MINUS SIGN}")

    value, low, high = _ends(name, row)
    if value is None:
        return _Cell("")
    if low is None or high is None:
        return _Cell(text(value))
    return _Cell(text(value), f"[{text(low)}, {text(high)}]")


def _latex_row(cells: Sequence[str]) -> str:
    return f"{' & '.join(cells)} \\\\"


def _small(text: str) -> str:
    """A small text of LaTeX."""
    return f"{{\\scriptsize {_in_latex(text).replace('p', '$p$', 1)}}}" if text else ""


def _in_latex(text: str) -> str:
    return "".join(_LATEX.get(each) or one_line(each) for each in text)


def _in_markdown(text: str) -> str:
    """A cell of a table of Markdown."""
    return one_line(text.replace("|", "\\|").replace("<", "\\<"))
