"""Plots of a report, for docs/speed.md."""

from pathlib import Path
from typing import Any, Callable, Dict, List, NamedTuple, Optional, Tuple

from flatland_benchmark.figures import ROBOTS, in_words
from flatland_benchmark.report import Report
from flatland_server.exceptions import FlatlandError

OURS, BOX2D, ORIGINAL, INK = "#2a6fdb", "#9aa4b2", "#d9822b", "#333333"

# The original Flatland in C++, 2 cores, each robot as in `robot_worlds`: times real time by robots.
ORIGINAL_UNSUBSCRIBED = {1: 146.0, 10: 14.0, 50: 1.5, 100: 0.67}
ORIGINAL_SUBSCRIBED = {10: 13.0, 100: 0.6}


class Part(NamedTuple):
    """A part of a step in the plot."""

    name: str
    color: str


PARTS = (
    Part("physics", "#4c9f70"),
    Part("scans", OURS),
    Part("plugins", ORIGINAL),
    Part("publishing", "#b65fa8"),
    Part("markers", BOX2D),
)


def require_matplotlib() -> None:
    """Raises FlatlandError if matplotlib, which only plots need, is missing."""
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        raise FlatlandError(
            "plots need matplotlib, which is missing: apt-get install python3-matplotlib"
        ) from None


def draw(report: Report, folder: Path) -> List[Path]:
    """Draws all plots that the report has figures for. Returns the PNG files.

    Raises:
        FlatlandError: matplotlib is missing, or there is nothing to plot.
    """
    require_matplotlib()
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    style = {
        "font.size": 11,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.edgecolor": INK,
        "legend.frameon": False,
        "savefig.dpi": 120,
        "savefig.bbox": "tight",
    }
    plots: Dict[str, Callable[[Any, Report], Optional[Any]]] = {
        "robots": _draw_robots,
        "rays": _draw_rays,
        "step": _draw_step,
    }
    paths = []
    folder.mkdir(parents=True, exist_ok=True)
    with pyplot.rc_context(style):
        for name, draw_one in plots.items():
            figure = draw_one(pyplot, report)
            if figure is not None:
                paths.append(folder / f"speed_{name}.png")
                figure.savefig(paths[-1])
                pyplot.close(figure)
    if not paths:
        raise FlatlandError("none of these cases is plotted; scan_*, serve_* and parts_* are")
    return paths


def _median(report: Report, case: str, figure: str) -> float:
    return report.cases[case].figures[figure].median


def _by_robots(report: Report, pattern: str) -> Dict[int, float]:
    """Times real time by number of robots, which replaces the braces in the case's name."""
    cases = {n: pattern.format(n) for n in ROBOTS}
    return {
        n: _median(report, case, "times real time")
        for n, case in cases.items()
        if case in report.cases
    }


def _draw_robots(pyplot: Any, report: Report) -> Optional[Any]:
    """Times real time by robots, with the original's."""
    unsubscribed = _by_robots(report, "serve_{}") or _by_robots(report, "robots_{}")
    subscribed = _by_robots(report, "serve_{}_heard")
    if not unsubscribed:
        return None
    figure, axes = pyplot.subplots(figsize=(7.2, 4.4))
    lines: List[Tuple[str, Dict[int, float], str, str]] = [
        ("no subscribers", unsubscribed, OURS, "-"),
        ("all topics subscribed to", subscribed, OURS, ":"),
        ("the original, no subscribers", ORIGINAL_UNSUBSCRIBED, ORIGINAL, "-"),
        ("the original, all topics subscribed to", ORIGINAL_SUBSCRIBED, ORIGINAL, ":"),
    ]
    for label, values, color, style in lines:
        if values:
            axes.plot(*zip(*values.items()), style, color=color, marker="o", label=label, lw=2)
    axes.axhline(1.0, color=INK, lw=0.8)
    axes.text(0.01, 1.06, "real time", transform=axes.get_yaxis_transform())
    axes.set(xscale="log", yscale="log", xlabel="robots")
    axes.set_title("Times real time", loc="left")
    _label(axes.xaxis, {n: f"{n:,}" for n in sorted({*unsubscribed, *ORIGINAL_UNSUBSCRIBED})})
    axes.minorticks_off()
    axes.yaxis.set_major_formatter(lambda value, _: f"{value:,g}")
    axes.grid(axis="y", alpha=0.3)
    axes.legend()
    return figure


_SCENES = {
    "scan_office": "office",
    "scan_office_far": "office, 100 m",
    "scan_noisy_map": "200,000 segments",
    "scan_room": "empty room",
    "scan_bodies": "room, 50 bodies",
    "scan_office_bodies": "lobby, 50 bodies",
}


def _draw_rays(pyplot: Any, report: Report) -> Optional[Any]:
    """Time of a beam by scene [ns], beside Box2D's."""
    cases = [case for case in _SCENES if case in report.cases]
    if not cases:
        return None
    figure, axes = pyplot.subplots(figsize=(7.2, 0.8 + 0.65 * len(cases)))
    height = 0.38
    for place, case in enumerate(cases):
        ours, theirs, times = (
            _median(report, case, key) for key in ("beam", "Box2D's beam", "times Box2D")
        )
        axes.barh(place - height / 2, theirs, height, color=BOX2D)
        axes.text(theirs, place - height / 2, f"  {theirs:,.0f}", va="center", fontsize=9)
        axes.barh(place + height / 2, ours, height, color=OURS)
        text = f"  {ours:,.0f}: {times:.2g} times as fast"
        axes.text(ours, place + height / 2, text, va="center", fontsize=9, color=OURS)
    axes.set_title("Nanoseconds of a beam, one thread", loc="left")
    _label(axes.yaxis, dict(enumerate(_SCENES[case] for case in cases)))
    axes.tick_params(axis="y", length=0)
    axes.invert_yaxis()
    axes.margins(x=0.12)
    axes.xaxis.set_major_formatter(lambda value, _: f"{value:,g}")
    bars = [pyplot.Rectangle((0, 0), 1, 1, color=color) for color in (BOX2D, OURS)]
    labels = ["b2World::RayCast", "Flatland"]
    axes.legend(bars, labels, ncol=2, loc="upper center", bbox_to_anchor=(0.5, -0.07))
    return figure


def _draw_step(pyplot: Any, report: Report) -> Optional[Any]:
    """Time of a step by part [us]."""
    rows = [robots for robots in (1, 100) if f"parts_{robots}" in report.cases]
    if not rows:
        return None
    figure, all_axes = pyplot.subplots(len(rows), figsize=(7.2, 2.1 * len(rows)), squeeze=False)
    for axes, robots in zip(all_axes[:, 0], rows):
        cases = {f"parts_{robots}_heard": "all topics", f"parts_{robots}": "no subscribers"}
        labels = {}
        for place, (case, label) in enumerate(cases.items()):
            if case not in report.cases:
                continue
            left = 0.0
            for part in PARTS:
                value = _median(report, case, part.name)
                axes.barh(place, value, 0.6, left=left, color=part.color, label=part.name)
                left += value
            axes.text(left, place, f"  {left:,.0f}", va="center", fontsize=9)
            labels[place] = label
        _label(axes.yaxis, labels)
        axes.tick_params(axis="y", length=0)
        axes.margins(x=0.1)
        axes.xaxis.set_major_formatter(lambda value, _: f"{value:,g}")
        axes.set_title(f"{in_words(robots)}: microseconds of a step", loc="left")
    handles, names = all_axes[0, 0].get_legend_handles_labels()
    unique = dict(zip(names, handles))
    figure.tight_layout()
    figure.legend(
        unique.values(), unique.keys(), ncol=len(PARTS), loc="upper center", bbox_to_anchor=(0.5, 0)
    )
    return figure


def _label(axis: Any, labels: Dict[Any, str]) -> None:
    """Sets the ticks of an axis to these labels only."""
    axis.set_ticks(list(labels))
    axis.set_ticklabels(list(labels.values()))
