"""flatland sweep --replay: one scenario of a sweep alone, on a page or into a recording."""

import sys
from contextlib import ExitStack
from pathlib import Path
from typing import List, Optional

from flatland2d.picture_page import PicturePage
from flatland2d.rendering.image_canvas import ImageCanvas
from flatland2d.rendering.renderer import Renderer, to_array
from flatland2d.sweep.fingerprints import Fingerprints
from flatland2d.sweep.report import draw_goal
from flatland2d.sweep.run import RunObserver, SweepRun
from flatland2d.sweep.runner import Result, ScenarioRunner
from flatland2d.sweep.settings import SweepSettings, scenario_of
from flatland2d.sweep.sweep import JOURNAL, read_entries
from flatland_server.canvas import Rgba

_SIZE = (1280, 800)  # px
_WIDTH = 12.0  # m
_RATE = 20.0  # pictures per second
_TEXT: Rgba = (0.15, 0.15, 0.15, 1.0)
_TEXT_AT = (10.0, 10.0)  # px


def replay(
    settings: SweepSettings, number: int, folder: Path, view: bool, recording: Optional[str]
) -> int:
    """Runs a scenario, and prints its result.

    Args:
        settings: the content of the scenario file.
        number: the scenario's number.
        folder: folder with the results of the sweep, which need not exist.
        view: whether the run is shown on a page, in real time; it begins once a browser shows it.
        recording: the file that its messages are recorded into, if any.

    Returns:
        The exit code: 1 if the scenario could not be run to the end.

    Raises:
        FlatlandError: there is no such scenario, or the recording cannot be written.
    """
    scenario = scenario_of(settings, number)
    results = read_entries(folder / JOURNAL)
    before = results.get(Fingerprints(settings).of(scenario)) if results else None
    runner = ScenarioRunner(settings)
    with ExitStack() as stack:
        parts: List[RunObserver] = []
        if recording is not None:
            parts.append(_Recording(recording, stack))
        if view:
            parts.append(_Show(stack.enter_context(PicturePage(str(scenario), _RATE))))
        result = runner.run(scenario, *parts)
    print(scenario)
    for name, value in {**result.row, **result.returned}.items():
        if value is not None:
            print(f"{name}: {value}")
    if before is not None:
        print(_comparison(result, before, folder))
    if recording is not None:
        print(f"recorded in {recording}")
    if result.error:
        print(result.traceback + f"it could not be run to the end: {result.error}", file=sys.stderr)
    return 1 if result.error else 0


def _comparison(now: Result, before: Result, folder: Path) -> str:
    """A line that compares a result with that of the sweep."""
    new, old = ({**r.row, **r.returned, "error": r.error} for r in (now, before))
    # NaN differs from itself; its string does not.
    different = [n for n in {**old, **new} if repr(new.get(n)) != repr(old.get(n))]
    if not different:
        return f"the same as in {folder}"
    values = ", ".join(f"{name} is {old.get(name)}" for name in different)
    return f"not the same as in {folder}, where {values}"


class _Recording(RunObserver):
    """Records all topics."""

    def __init__(self, path: str, stack: ExitStack) -> None:
        self._path = path
        self._stack = stack

    def on_begin(self, run: SweepRun) -> None:
        self._stack.enter_context(run.simulation.record(self._path))


class _Show(RunObserver):
    """Shows a run on a page in the browser, in real time."""

    def __init__(self, page: PicturePage) -> None:
        self._page = page
        self._next = 0.0  # simulated time of the next picture [s]

    def on_begin(self, run: SweepRun) -> None:
        self._renderer = Renderer(run.simulation.world, run.simulation.timekeeper)
        self._show(run)
        self._page.wait_until_open()

    def on_step(self, run: SweepRun) -> None:
        if run.time >= self._next:
            self._show(run)

    def on_end(self, run: SweepRun) -> None:
        self._show(run, f"  ended: {run.outcome}")

    def _show(self, run: SweepRun, end: str = "") -> None:
        robot = run.robot.name if run.path else None
        view = self._renderer.view(_SIZE, follow=robot, width=_WIDTH)
        image = self._renderer.image(view, sensors=True, trails=[run.path] if run.path else [])
        canvas = ImageCanvas(image, view)
        draw_goal(canvas, run)
        canvas.label(view.position(_TEXT_AT), f"{run.time:.1f} s{end}", _TEXT)
        self._page.show(to_array(image))
        self._next = run.time + 1.0 / _RATE
