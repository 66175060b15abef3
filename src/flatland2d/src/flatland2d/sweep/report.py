"""The report of a sweep: one HTML file, with pictures of runs without success."""

import base64
import html
from typing import Any, Dict, List, Mapping, Sequence, Tuple

import numpy as np

from flatland2d.rendering.image_canvas import ImageCanvas
from flatland2d.rendering.renderer import Renderer, to_png
from flatland2d.rendering.view import View, fitting_size
from flatland2d.sweep.intervals import CONFIDENCE
from flatland2d.sweep.metrics import SUMMARISED
from flatland2d.sweep.run import RunObserver, SweepRun
from flatland2d.sweep.runner import ScenarioRunner
from flatland2d.sweep.settings import Scenario
from flatland2d.sweep.tables import one_line
from flatland_server.canvas import Canvas, Rgba
from flatland_server.exceptions import listed
from flatland_server.geometry import Point

_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; margin: 2em auto; max-width: 1200px; padding: 0 1em;
  color: #222; }
table { border-collapse: collapse; margin: 1em 0; display: block; overflow-x: auto; }
th, td { border-bottom: 1px solid #ddd; padding: .3em .8em; text-align: left; white-space: nowrap; }
td.number { text-align: right; font-variant-numeric: tabular-nums; }
small { color: #666; }
figure { display: inline-block; vertical-align: top; margin: 0 1.5em 1.5em 0; max-width: 480px; }
figcaption { font-size: 13px; overflow-wrap: anywhere; }
code { background: #f2f2f0; padding: 0 .3em; }
"""

_FORMULAS = (
    f"Intervals are of {CONFIDENCE:.0%} confidence. Rates: Wilson's score interval. Means: "
    "Student's t, m &plusmn; t<sub>0.975, n-1</sub> s / &radic;n. Scenarios that failed to run to "
    "the end are in neither. <code>time_to_goal</code> is the mean of those that reached the goal."
)

Picture = Tuple[Mapping[str, Any], bytes]
"""A row of the table of results, and a PNG file."""


def report_html(
    title: str,
    command: str,
    summary: Sequence[Mapping[str, Any]],
    rows: Sequence[Mapping[str, Any]],
    pictures: Sequence[Picture],
) -> str:
    """The report.

    Args:
        title: such as the name of the scenario file.
        command: command that replays a scenario when its number is appended.
        summary: see `summary_rows`.
        rows: see `rows_of`.
        pictures: pictures of some scenarios without success.
    """
    parts = [
        f"<h1>{html.escape(title)}</h1>",
        f"<p>{len(rows)} scenarios, {_count(rows, 'success', True)} with success, "
        f"{_count(rows, 'collision', True)} with a collision, "
        f"{_count(rows, 'status', 'failed')} failed to run to the end.</p>",
        _summary_table(summary),
        f"<p><small>{_FORMULAS}</small></p>",
        _failures(rows),
        _figures(command, rows, pictures),
    ]
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{html.escape(title)}'
        f"</title><style>{_STYLE}</style></head>\n<body>\n"
        + "\n".join(parts)
        + "\n</body></html>\n"
    )


def summary_cells(
    summary: Sequence[Mapping[str, Any]], is_brief: bool = False
) -> Tuple[List[str], List[List[str]]]:
    """The heads and the cells of the summary, each estimate with its interval in one cell.

    Args:
        summary: see `summary_rows`.
        is_brief: whether metrics are left out that are not compared with a baseline.
    """
    names = list(summary[0]) if summary else []
    heads = [
        name
        for name in names
        if not any(
            name == f"{other}{end}" for other in names for end in ("_low", "_high", "_count")
        )
        and not (is_brief and name in SUMMARISED and not SUMMARISED[name].is_gated)
    ]
    cells = [[_cell(row, name) for name in heads] for row in summary]
    used = [i for i, _ in enumerate(heads) if any(row[i] for row in cells)]
    return [heads[i] for i in used], [[row[i] for i in used] for row in cells]


def text_table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table for a terminal."""
    lines = [list(map(one_line, line)) for line in (heads, *rows)]
    widths = [max(len(line[i]) for line in lines) for i in range(len(heads))]
    return "\n".join(
        "  ".join(word.ljust(width) for word, width in zip(line, widths)).rstrip() for line in lines
    )


def unsuccessful(rows: Sequence[Mapping[str, Any]]) -> List[Mapping[str, Any]]:
    """The rows of runs that ended without success, with a collision or with an exception.

    Runs that crashed or hung are left out: a picture needs another run, which would do the same.
    """
    ended = [row for row in rows if row["outcome"]]
    return [row for row in ended if row["success"] is False or row["collision"] or row["error"]]


def _cell(row: Mapping[str, Any], name: str) -> str:
    value = row[name]
    if value is None:
        return ""
    if f"{name}_low" not in row:
        return f"{value:g}" if isinstance(value, float) else str(value)
    is_rate = name in SUMMARISED and SUMMARISED[name].is_rate
    low, high = row[f"{name}_low"], row[f"{name}_high"]
    if is_rate:
        return f"{value:.1%} [{low:.1%}, {high:.1%}]"
    return f"{value:.3g}" + (f" [{low:.3g}, {high:.3g}]" if low is not None else "")


def _summary_table(summary: Sequence[Mapping[str, Any]]) -> str:
    heads, cells = summary_cells(summary)
    head = "".join(f"<th>{html.escape(name)}</th>" for name in heads)
    body = "\n".join(
        "<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in cells
    )
    return f"<table><tr>{head}</tr>\n{body}</table>"


def _failures(rows: Sequence[Mapping[str, Any]]) -> str:
    """The scenarios that failed to run to the end, by their reasons."""
    reasons: Dict[str, List[int]] = {}
    for row in rows:
        if row["error"]:
            reasons.setdefault(row["error"], []).append(row["scenario"])
    if not reasons:
        return ""
    items = "".join(
        f"<li>{len(numbers)}: {html.escape(reason)} "
        f"<small>(scenario {listed(list(map(str, numbers)))})</small></li>"
        for reason, numbers in reasons.items()
    )
    return f"<h2>Failed to run to the end</h2><ul>{items}</ul>"


def _figures(command: str, rows: Sequence[Mapping[str, Any]], pictures: Sequence[Picture]) -> str:
    if not pictures:
        return ""
    count = len(unsuccessful(rows))
    figures = "\n".join(_figure(command, row, picture) for row, picture in pictures)
    return (
        f"<h2>Without success</h2><p>{len(pictures)} of {count}. The line is the robot's path from "
        f"its start (dot); the green disc is the goal.</p>\n{figures}"
    )


def _figure(command: str, row: Mapping[str, Any], picture: bytes) -> str:
    shown = {
        name: f"{value:.4g}" if isinstance(value, float) else value
        for name, value in row.items()
        if value is not None and not name.startswith(("start_", "goal_"))
    }
    text = ", ".join(f"{name} {value}" for name, value in shown.items() if name != "scenario")
    data = base64.b64encode(picture).decode()
    return (
        f'<figure><img alt="scenario {row["scenario"]}" src="data:image/png;base64,{data}">'
        f"<figcaption><b>Scenario {row['scenario']}</b>: {html.escape(text)}<br>"
        f"<code>{html.escape(command)} {row['scenario']} --view</code></figcaption></figure>"
    )


def _count(rows: Sequence[Mapping[str, Any]], name: str, value: Any) -> int:
    return sum(row[name] == value for row in rows)


# Pictures

_LONGER_SIDE = 480  # px
_ROOM = 3.0  # m, around the path and the goal
_LEAST_ASPECT = 0.4
_GOAL: Rgba = (0.2, 0.65, 0.3, 0.35)
_GOAL_OUTLINE: Rgba = (0.1, 0.5, 0.2, 0.9)
_GOAL_WIDTH = 1.5  # px
_START: Rgba = (0.2, 0.5, 0.8, 1.0)
_START_SIZE = 9.0  # px


def draw(runner: ScenarioRunner, scenario: Scenario) -> bytes:
    """Runs a scenario again, and draws it.

    Returns:
        The content of a PNG file; empty if the world cannot be loaded or has no robot.
    """
    artist = _Artist()
    runner.run(scenario, artist)
    return artist.picture


class _Artist(RunObserver):
    """Draws a run at its end."""

    picture = b""

    def on_end(self, run: SweepRun) -> None:
        if not run.path:  # without a robot
            return
        renderer = Renderer(run.simulation.world, run.simulation.timekeeper)
        low, high = _corners(run)
        view = View.of(low, high, fitting_size(low, high, _LONGER_SIDE))
        image = renderer.image(view, trails=[run.path])
        canvas = ImageCanvas(image, view)
        canvas.dots([run.path[0]], _START, _START_SIZE)
        draw_goal(canvas, run)
        self.picture = to_png(image)


def draw_goal(canvas: Canvas, run: SweepRun) -> None:
    """Draws the goal of the robot."""
    if run.goal is not None:
        canvas.disc(run.goal, run.goal_radius, _GOAL, _GOAL_OUTLINE, _GOAL_WIDTH)


def _corners(run: SweepRun) -> Tuple[Point, Point]:
    """The lower left and the upper right corner of a picture of the path and the goal [m]."""
    places = np.array([*run.path, *([run.goal] if run.goal else [])])
    low, high = places.min(axis=0) - _ROOM, places.max(axis=0) + _ROOM
    least = _LEAST_ASPECT * float((high - low).max())
    for side in (0, 1):
        missing = max(0.0, least - (high[side] - low[side]))
        low[side] -= missing / 2
        high[side] += missing / 2
    return (float(low[0]), float(low[1])), (float(high[0]), float(high[1]))
