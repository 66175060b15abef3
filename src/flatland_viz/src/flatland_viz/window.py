"""The window: menus, rviz's toolbar and view, and a status line."""

import time
from pathlib import Path
from typing import Dict, FrozenSet, List, Optional

from python_qt_binding.QtCore import QEvent, QObject, Qt, QTimer
from python_qt_binding.QtGui import QKeySequence
from python_qt_binding.QtWidgets import (
    QApplication,
    QInputDialog,
    QMainWindow,
    QMenu,
    QMessageBox,
    QShortcut,
)

from flatland_viz.displays import Shown, wanted
from flatland_viz.drive_panel import DrivePanel
from flatland_viz.file_dialog import ask_for_file
from flatland_viz.ground_truth import GroundTruth
from flatland_viz.keys_dialog import DRIVING, MOUSE, KeysDialog, rows_of
from flatland_viz.menus import Menus
from flatland_viz.model_list import Model
from flatland_viz.model_workbench import ModelWorkbench
from flatland_viz.navigation_tools import wanted_tools
from flatland_viz.problem_badge import ProblemBadge
from flatland_viz.problem_sources import ProblemSources
from flatland_viz.scene import RATE_TOOL, Scene
from flatland_viz.screenshot import picture_of, write_picture
from flatland_viz.selection import Selection
from flatland_viz.server import Server
from flatland_viz.settings import Settings
from flatland_viz.status import Simulation, has_restarted, is_gone, status
from flatland_viz.status_line import StatusLine
from flatland_viz.theme import Theme
from flatland_viz.timeline import Timeline
from flatland_viz.toolbar import Toolbar, key_of
from flatland_viz.window_size import first_size
from flatland_viz.world_files import title
from flatland_viz.world_saving import WorldSaving

_STEPS = "steps"
_REFRESH_PERIOD = 200  # ms: of the status line
_ROOM_FOR_BOTH = 600  # pixels: least height of a window with the panels Models and Drive
_MENU_CLOSING_TIME = 200  # ms: until a menu is off the screen
_OTHER_KEYS = Qt.ControlModifier | Qt.AltModifier | Qt.MetaModifier
_RESET_DELAYS = (200, 3000)
"""Delays after a server's restart at which the displays subscribe again [ms]. rviz discards all
messages, even latched ones, when it notices that time went back, at an unknown time in between."""


class Window(QMainWindow):
    """Shows the world of a server, also before that runs and after it has ended."""

    def __init__(
        self, server: Server, scene: Scene, problems: ProblemSources, theme: Theme
    ) -> None:
        super().__init__()
        self._server = server
        self._scene = scene
        self.is_closed = False
        """True if the user has closed it."""
        self._world = ""
        self._models: Dict[str, Model] = {}
        self._goals: FrozenSet[str] = frozenset()
        self._simulation: Optional[Simulation] = None
        self._last_message = time.monotonic()
        self.setObjectName("flatland")
        self.setWindowTitle(title(""))
        self.setCentralWidget(scene.frame)
        self._line = StatusLine()
        self.setStatusBar(self._line)
        self._timeline = Timeline()
        self.addToolBar(Qt.BottomToolBarArea, self._timeline)
        self._badge = ProblemBadge(self._line, problems)
        self._settings = Settings()
        self._theme = theme
        self.selection = Selection()
        self._drive = DrivePanel(self.selection, self._settings)
        self.addDockWidget(Qt.RightDockWidgetArea, self._drive)
        self._drive.hide()
        self._menus = Menus(self.menuBar(), [self._drive, *scene.docks], self._settings)
        self._menus.add_toolbar(scene.toolbar)
        self._menus.enable_spawning(scene.can_spawn)
        self._ground_truth = GroundTruth(
            scene.models, self._line, self.menuBar().findChild(QMenu, "menu_simulation")
        )
        self._workbench = ModelWorkbench(self, server, scene, self.selection, self._line)
        size = first_size(QApplication.primaryScreen().availableSize())
        if size.height() < _ROOM_FOR_BOTH:
            self.tabifyDockWidget(self._workbench.panel, self._drive)
        else:
            self.splitDockWidget(self._workbench.panel, self._drive, Qt.Vertical)
        self._drive.toggleViewAction().triggered.connect(self._make_room_to_drive)
        self.selection.drive_asked.connect(lambda _: self._make_room_to_drive(True))
        self._saving = WorldSaving(self, server, self._menus, self._workbench)
        self._toolbar = Toolbar(scene.toolbar, scene.tools)
        self._toolbar.add(self._menus.step, "step", "Step")
        self._toolbar.add(self._menus.reset, "reset", "Reset")
        self._toolbar.add(self._drive.toggleViewAction(), "drive", "Drive")
        self._connect()
        self._refresh()
        scene.panel.installEventFilter(self)
        self._settings.follow_switches(self._menus.view)
        if not self._settings.restore_window(self, scene.frame):
            self.resize(size)

    def _connect(self) -> None:
        server, scene, menus = self._server, self._scene, self._menus
        server.simulation_changed.connect(self._on_simulation)
        server.displays_changed.connect(self._on_displays)
        server.navigation_changed.connect(self._on_goals)
        self.selection.changed.connect(lambda _: self._show_navigation_tools())
        server.renewed.connect(self._badge.forget_events)
        server.renewed.connect(self._workbench.note_saved)
        server.world_changed.connect(self._on_world)
        server.failed.connect(self._line.show_message)
        server.models_changed.connect(self._on_models)
        server.publishers_changed.connect(self._drive.set_publishers)
        server.done.connect(self._line.show_message)
        server.refused.connect(self._show_error)
        scene.hints.connect(self._line.show_hint)
        scene.walls_progress.connect(lambda percent: self._line.show_progress("walls", percent))
        server.loading_changed.connect(lambda percent: self._line.show_progress("world", percent))
        menus.world_chosen.connect(self._open)
        menus.other_world_asked.connect(self._open_other)
        menus.reload_asked.connect(server.reload)
        menus.world_reset_asked.connect(server.reset)
        self._timeline.sought.connect(server.seek)
        menus.seek_asked.connect(self._seek)
        menus.step_asked.connect(lambda: server.step(1))
        menus.steps_asked.connect(self._ask_for_steps)
        menus.keys_asked.connect(self._show_keys)
        menus.spawn_asked.connect(scene.spawn)
        menus.screenshot_asked.connect(self._take_screenshot)
        menus.reset_asked.connect(scene.reset_view)
        menus.layout_reset_asked.connect(
            lambda: self._settings.reset_layout(self, self._scene.frame)
        )
        menus.quit_asked.connect(self.close)
        for asks in (menus, self._line):
            asks.pause_asked.connect(lambda on: server.pause() if on else server.resume())
        self._line.rate_asked.connect(lambda: scene.use_tool(RATE_TOOL))
        menus.rate_chosen.connect(server.change_rate)
        menus.background_chosen.connect(scene.set_background)
        menus.background_chosen.connect(self._theme.apply)
        QShortcut(QKeySequence("Esc"), self, scene.leave_tool)
        self._clock = QTimer(self)
        self._clock.timeout.connect(self._refresh)
        self._clock.start(_REFRESH_PERIOD)

    def _on_simulation(self, simulation: Simulation) -> None:
        if has_restarted(self._simulation, self._silence(), simulation):
            self._workbench.note_saved()
            for delay in _RESET_DELAYS:
                QTimer.singleShot(delay, self._scene.begin_again)
        self._simulation = simulation
        self._last_message = time.monotonic()
        self._refresh()

    def _silence(self) -> float:
        return time.monotonic() - self._last_message

    def _refresh(self) -> None:
        """Updates the status line and the menus."""
        silence = self._silence()
        self._line.show_status(status(self._simulation, silence))
        simulation = None if is_gone(silence) else self._simulation
        self._menus.show_simulation(simulation)
        self._saving.show_edits(simulation.edits if simulation is not None else 0)
        self._timeline.show_simulation(simulation)

    def _seek(self, seconds: float) -> None:
        """Goes back, if it is negative, or on within the run."""
        if self._simulation is not None:
            begin, end = self._simulation.begin, self._simulation.end
            self._server.seek(min(max(self._simulation.time + seconds, begin), end))

    def _on_displays(self, others: List[Shown]) -> None:
        self._scene.show_displays(wanted(self._server.debug, others))

    def _on_models(self, models: Dict[str, Model]) -> None:
        self._models = models
        self._drive.set_models(models)
        self._show_navigation_tools()

    def _on_goals(self, topics: FrozenSet[str]) -> None:
        self._goals = topics
        self._show_navigation_tools()

    def _show_navigation_tools(self) -> None:
        """Shows the tools for goals of the selected robot."""
        robot = self._models.get(self.selection.name)
        wanted = wanted_tools(self._goals, robot.namespace if robot else "")
        self._scene.show_navigation_tools(wanted)
        self._toolbar.describe(self._scene.tools)

    def _on_world(self, path: str) -> None:
        is_other = bool(self._world)
        self._world = path
        self.setWindowTitle(title(path))
        self._menus.set_world(path)
        self._saving.set_world(path)
        if is_other:
            self._badge.forget_events()
            self._scene.reset_view()

    def _make_room_to_drive(self, is_shown: bool) -> None:
        """Lets the panel Models shrink rather than Drive, of which all is used."""
        if is_shown:
            self.resizeDocks([self._drive], [self._drive.sizeHint().height()], Qt.Vertical)

    def showEvent(self, event: QEvent) -> None:  # noqa: N802
        """Lets the Drive panel take the window's keys."""
        super().showEvent(event)
        self._drive.start()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        """Keeps the world framed while the view is resized; hides keys with modifiers from rviz.

        rviz ignores modifiers: Ctrl+A would spawn a model, as A does.
        """
        if event.type() == QEvent.Resize:
            self._scene.follow_size()
        return event.type() == QEvent.KeyPress and bool(event.modifiers() & _OTHER_KEYS)

    def closeEvent(self, event: QEvent) -> None:  # noqa: N802
        """Ends the program, even if dialogs are open; asks first if there are unsaved changes.

        The layout is saved while it is whole.
        """
        if not self.is_closed and self._saving.keep_changes("closing", self._close_at_once):
            event.ignore()
            return
        self._settings.save_window(self, self._scene.frame)
        super().closeEvent(event)
        self._drive.stop()
        self.is_closed = True
        QApplication.quit()

    def _close_at_once(self) -> None:
        self.is_closed = True
        self.close()

    def finish(self) -> None:
        """Stops a robot that it drives; saves the layout if it was not closed by the user."""
        self._drive.stop()
        if not self.is_closed:
            self._settings.save_window(self, self._scene.frame)

    def _show_error(self, what: str, why: str) -> None:
        box = QMessageBox(QMessageBox.Warning, "Flatland", what, QMessageBox.Close, self)
        box.setObjectName("error")
        box.setStyleSheet("#qt_msgbox_informativelabel { min-width: 30em }")
        box.setTextFormat(Qt.PlainText)
        box.setInformativeText(why)
        box.setTextInteractionFlags(Qt.TextSelectableByMouse)
        box.setAttribute(Qt.WA_DeleteOnClose)
        box.open()

    def _open_other(self) -> None:
        folder = str(Path(self._world).parent) if self._world else ""
        file = ask_for_file(self, "Open a World", folder, "Worlds (*.yaml *.yml);;All files (*)")
        if file:
            self._open(file)

    def _open(self, world: str) -> None:
        if not self._saving.keep_changes("opening another world", lambda: self._server.open(world)):
            self._server.open(world)

    def _ask_for_steps(self) -> None:
        before = int(self._settings.number(_STEPS, 100))
        count, is_given = QInputDialog.getInt(self, "Steps", "&Steps:", before, 1, 1_000_000)
        if is_given:
            self._settings.set_number(_STEPS, count)
            self._server.step(count)

    def _show_keys(self) -> None:
        dialog = self.findChild(KeysDialog)
        if dialog is None:
            dialog = self._keys_dialog()
        dialog.show()
        dialog.raise_()
        dialog.activateWindow()

    def _keys_dialog(self) -> KeysDialog:
        menus = [(title, rows_of(menu)) for title, menu in self._menus.titled]
        tools = [(key_of(tool), tool.getName()) for tool in self._scene.tools if key_of(tool)]
        others = [("Tools", tools), ("Driving, in the Drive panel", DRIVING), ("Mouse", MOUSE)]
        return KeysDialog(self, [menus, others])

    def _take_screenshot(self) -> None:
        QTimer.singleShot(_MENU_CLOSING_TIME, self._save_screenshot)  # without the menu in it

    def _save_screenshot(self) -> None:
        picture = picture_of(self._scene.panel)
        name = time.strftime("flatland_%Y-%m-%d_%H-%M-%S.png")
        start = str(Path.home() / name)
        file = ask_for_file(self, "Save a screenshot", start, "PNG (*.png)", is_new=True)
        if not file:
            return
        if write_picture(picture, file):
            self._line.show_message(f"Saved {file}")
        else:
            QMessageBox.warning(self, "Save a screenshot", f"{file} cannot be written.")
