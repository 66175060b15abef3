"""flatland sweep --replay: one scenario of a sweep alone, in a window or into a recording."""

import sys
from contextlib import ExitStack
from pathlib import Path
from typing import Any, List, Optional

from PIL import Image

from flatland2d.rendering.image_canvas import ImageCanvas
from flatland2d.sweep.fingerprints import Fingerprints
from flatland2d.sweep.report import draw_goal
from flatland2d.sweep.run import RunObserver, SweepRun
from flatland2d.sweep.runner import Result, ScenarioRunner
from flatland2d.sweep.settings import SweepSettings, scenario_of
from flatland2d.sweep.sweep import JOURNAL, read_entries
from flatland2d.viewer.keyboard_drive import KeyboardDrive
from flatland2d.viewer.viewer import Viewer
from flatland_teleop.driving_keys import Direction

_SIZE = (1280, 800)


def replay(
    settings: SweepSettings, number: int, folder: Path, view: bool, recording: Optional[str]
) -> int:
    """Runs a scenario, and prints its result.

    Args:
        settings: the content of the scenario file.
        number: of the scenario.
        folder: has the results of the sweep, if there are any.
        view: whether the run is shown in a window.
        recording: the file that its messages are recorded into, if any.

    Returns:
        The exit code: 1 if the scenario could not be run to the end.

    Raises:
        FlatlandError: there is no such scenario, or no screen, or the recording cannot be written.
    """
    scenario = scenario_of(settings, number)
    before = read_entries(folder / JOURNAL)
    entry = before.get(Fingerprints(settings).of(scenario)) if before else None
    runner = ScenarioRunner(settings)
    with ExitStack() as stack:
        stack.callback(runner.close)
        parts: List[RunObserver] = []
        if recording is not None:
            parts.append(_Recording(recording, stack))
        if view:
            parts.append(_Show(str(scenario), stack))
        try:
            result = runner.run(scenario, *parts)
        except _WindowClosed:
            return 0
    print(scenario)
    for name, value in {**result.row, **result.returned}.items():
        if value is not None:
            print(f"{name}: {value}")
    if entry is not None:
        print(_comparison(result, entry.result, folder))
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


class _WindowClosed(BaseException):
    """Ends a run when its window is closed. Not an Exception, so that no controller catches it."""


class _Show(RunObserver):
    """Shows a run in a window, in real time."""

    def __init__(self, title: str, stack: ExitStack) -> None:
        self._title = title
        self._stack = stack
        self._viewer: Optional[RunViewer] = None
        self._window: Any = None

    def on_begin(self, run: SweepRun) -> None:
        from flatland2d.viewer.window import Window  # needs pygame

        self._viewer = RunViewer(run)
        self._window = Window(self._viewer, self._title)
        self._stack.callback(self._window.close)

    def on_step(self, run: SweepRun) -> None:
        assert self._viewer is not None
        self._viewer.note_step()
        while not self._viewer.due:
            self._show_frame()

    def on_end(self, run: SweepRun) -> None:
        """Shows the end until the window is closed."""
        assert self._viewer is not None
        self._viewer.end(run.outcome)
        try:
            while True:
                self._show_frame()
        except _WindowClosed:
            pass

    def _show_frame(self) -> None:
        try:
            self._window.show_frame()
        except KeyboardInterrupt:
            raise _WindowClosed() from None
        if not self._window.is_open:
            raise _WindowClosed()


class RunViewer(Viewer):
    """A view of a run: its steps are made by its controller, when they are due.

    Args:
        run: is shown.

    Attributes:
        due: how many steps the controller may make now.
    """

    def __init__(self, run: SweepRun) -> None:
        follow = run.robot.name if run.path else None
        super().__init__(run.simulation, _SIZE, follow=follow, history=False)
        self.due = 0
        self.shows_trail = True
        self.drive = _NoDrive(run.simulation)
        self._run = run
        self._has_ended = False

    def note_step(self) -> None:
        """Notes that a step was made."""
        self.due = max(0, self.due - 1)
        self._trail.note(self.chosen, reads_odometry=False)

    def end(self, outcome: str) -> None:
        """Stops the time, and says how the run has ended."""
        self._has_ended = True
        self.playback.is_paused = True
        self.message = f"ended: {outcome}"

    def reset(self) -> None:
        self.message = "a run cannot be reset"

    def seek(self, time: float) -> None:
        self.message = "a run cannot go back: its controller does not"

    def toggle_pause(self) -> None:
        if not self._has_ended:
            super().toggle_pause()

    def image(self) -> Image.Image:
        image = super().image()
        draw_goal(ImageCanvas(image, self.view), self._run)
        return image

    def _step(self) -> None:
        if not self._has_ended:
            self.due += 1


class _NoDrive(KeyboardDrive):
    """The controller drives; keys do not."""

    def command(self, model: str, direction: Direction, *, is_slow: bool = False) -> None:
        pass
