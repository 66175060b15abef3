"""The window: menus, rviz's toolbar and view, panels, and a status line."""

import time
from pathlib import Path
from typing import Dict, FrozenSet, Optional

from python_qt_binding.QtCore import QEvent, QObject, Qt, QTimer
from python_qt_binding.QtGui import QKeySequence
from python_qt_binding.QtWidgets import QApplication, QMainWindow, QMenu, QMessageBox, QShortcut

from flatland_viz.actions import add_action
from flatland_viz.displays import wanted
from flatland_viz.drive_panel import DrivePanel
from flatland_viz.file_dialog import ask_for_file
from flatland_viz.keys_dialog import DRIVING, MOUSE, KeysDialog, rows_of
from flatland_viz.model_actions import ModelActions
from flatland_viz.model_list import Model, topic_owners
from flatland_viz.model_panel import ModelPanel
from flatland_viz.navigation_tools import wanted_tools
from flatland_viz.problem_badge import ProblemBadge
from flatland_viz.problem_sources import ProblemSources
from flatland_viz.scene import Scene
from flatland_viz.selection import Selection
from flatland_viz.server import Graph, Server
from flatland_viz.services import Services
from flatland_viz.settings import Settings
from flatland_viz.simulation_menu import SimulationMenu
from flatland_viz.status import Simulation, has_restarted, is_gone, status
from flatland_viz.status_line import StatusLine
from flatland_viz.theme import Theme
from flatland_viz.timeline import Timeline
from flatland_viz.toolbar import Toolbar, key_of
from flatland_viz.trail_display import TrailDisplay
from flatland_viz.view_menu import ViewMenu
from flatland_viz.window_size import on_screen
from flatland_viz.world_files import title
from flatland_viz.world_menu import WorldMenu

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
        self,
        server: Server,
        services: Services,
        scene: Scene,
        problems: ProblemSources,
        theme: Theme,
    ) -> None:
        super().__init__()
        self._server = server
        self._services = services
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
        self._problems = problems
        self._badge = ProblemBadge(self._line, problems)
        self._settings = Settings()
        self._selection = Selection()
        self._selection.follow_tools(scene.interact_tool, scene.spawn_tool)
        self._actions = ModelActions(self, services, self._selection, scene.follow)
        self._panel = ModelPanel(self._selection, self._actions)
        self._drive = DrivePanel(self._selection, self._settings)
        self._trail = TrailDisplay(scene.displays, self._selection)
        self._add_menus(theme)
        size = on_screen(1280, 800)
        self._add_panels(size.height())
        self._toolbar = Toolbar(scene.toolbar, scene.tools)
        self._toolbar.add(self._simulation_menu.step, "step", "Step")
        self._toolbar.add(self._world_menu.reset, "reset", "Reset")
        self._toolbar.add(self._drive.toggleViewAction(), "drive", "Drive")
        self._connect()
        self._refresh()
        scene.panel.installEventFilter(self)
        self._settings.follow_switches(self._view_menu)
        if not self._settings.restore_window(self, scene.frame):
            self.resize(size)

    def _add_menus(self, theme: Theme) -> None:
        services, scene = self._services, self._scene
        self._world_menu = world = WorldMenu(self, services, self._actions, self._settings)
        self._spawn = add_action(world, "S&pawn model...\tA", scene.spawn)
        world.addSeparator()
        add_action(world, "Save s&creenshot...", self._take_screenshot, "Ctrl+P")
        world.addSeparator()
        add_action(world, "&Quit", self.close, "Ctrl+Q")
        self._simulation_menu = SimulationMenu(self, services, self._settings)
        model = QMenu("&Model", self)
        model.addActions([self._actions.undo, self._actions.redo])
        model.addSeparator()
        self._actions.fill(model)
        self._view_menu = view = ViewMenu(self, scene, theme, self._trail)
        view.add_panels([self._drive, *scene.docks, self._panel])
        add_action(view, "Reset &layout", self._reset_layout)
        help_menu = QMenu("&Help", self)
        add_action(help_menu, "&Keys and mouse", self._show_keys, "F1")
        for menu in (world, self._simulation_menu, model, view, help_menu):
            self.menuBar().addMenu(menu)

    def _add_panels(self, height: int) -> None:
        for panel in (self._panel, self._drive):
            self.addDockWidget(Qt.RightDockWidgetArea, panel)
        self._drive.hide()
        if height < _ROOM_FOR_BOTH:
            self.tabifyDockWidget(self._panel, self._drive)
        else:
            self.splitDockWidget(self._panel, self._drive, Qt.Vertical)
        self._drive.toggleViewAction().triggered.connect(self._make_room_to_drive)
        self._selection.drive_asked.connect(lambda _: self._make_room_to_drive(True))

    def _connect(self) -> None:
        server, services, scene, line = self._server, self._services, self._scene, self._line
        server.simulation_changed.connect(self._on_simulation)
        server.graph_changed.connect(self._on_graph)
        server.models_changed.connect(self._on_models)
        server.loading_changed.connect(lambda percent: line.show_progress("world", percent))
        services.renewed.connect(self._problems.forget)
        services.renewed.connect(self._forget_edits)
        services.failed.connect(line.show_message)
        services.done.connect(line.show_message)
        services.refused.connect(self._show_error)
        scene.hints.connect(line.show_hint)
        scene.displays.walls_progress.connect(lambda percent: line.show_progress("walls", percent))
        self._colors, self._placed = map(scene.models.subProp, ("Colors", "Placed Frames"))
        self._colors.changed.connect(self._show_colors)
        self._placed.changed.connect(lambda: line.show_placed(self._placed.getValue()))
        self._selection.changed.connect(lambda _: self._show_navigation_tools())
        self._actions.hint.connect(line.show_message)
        self._actions.followed.connect(line.show_followed)
        line.following_ended.connect(self._actions.end_following)
        line.pause_asked.connect(services.toggle_pause)
        line.rate_asked.connect(self._simulation_menu.ask_for_rate)
        self._timeline.sought.connect(services.seek)
        QShortcut(QKeySequence("Esc"), self, scene.leave_tool)
        self._clock = QTimer(self)
        self._clock.timeout.connect(self._refresh)
        self._clock.start(_REFRESH_PERIOD)

    def _on_simulation(self, simulation: Simulation) -> None:
        if has_restarted(self._simulation, self._silence(), simulation):
            self._forget_edits()
            for delay in _RESET_DELAYS:
                QTimer.singleShot(delay, self._scene.begin_again)
        self._simulation = simulation
        self._last_message = time.monotonic()
        self._panel.set_time(simulation.time)
        self._actions.show_simulation(simulation)
        self._refresh()

    def _silence(self) -> float:
        return time.monotonic() - self._last_message

    def _refresh(self) -> None:
        """Updates the status line and the menus."""
        silence = self._silence()
        self._line.show_status(status(self._simulation, silence))
        simulation = None if is_gone(silence) else self._simulation
        for part in (self._world_menu, self._simulation_menu, self._timeline):
            part.show_simulation(simulation)

    def _forget_edits(self) -> None:
        """All changes of models are in the world's file, or are gone."""
        self._actions.has_edited = False

    def _on_graph(self, graph: Graph) -> None:
        self._scene.displays.show(wanted(self._server.debug, graph.displays))
        self._drive.set_publishers(graph.publishers)
        self._goals = graph.goals
        self._show_navigation_tools()
        if graph.world and graph.world != self._world:
            self._on_world(graph.world)

    def _on_world(self, path: str) -> None:
        if self._world:
            self._problems.forget()
            self._scene.framing.reset_view()
        self._world = path
        self._world_menu.set_world(path)

    def _on_models(self, models: Dict[str, Model]) -> None:
        self._models = models
        self._actions.set_models(models)
        self._drive.set_models(models)
        self._trail.set_models(models)  # before the panel subscribes to a topic of another type
        self._panel.set_models(models)
        self._show_colors()
        self._show_navigation_tools()

    def _show_colors(self) -> None:
        """Gives robots' scans, plans and goals, and the list, their colours."""
        colors: Dict[str, str] = self._colors.getValue()
        self._panel.set_colors(colors)
        owners = topic_owners(self._models)
        self._scene.displays.set_colors(
            {topic: colors[name] for topic, name in owners.items() if name in colors}
        )

    def _show_navigation_tools(self) -> None:
        """Shows the tools for goals of the selected robot."""
        robot = self._models.get(self._selection.name)
        tools = wanted_tools(self._goals, robot.namespace if robot else "")
        self._scene.show_navigation_tools(tools)
        self._toolbar.describe(self._scene.tools)

    def _make_room_to_drive(self, is_shown: bool) -> None:
        """Lets the panel Models shrink rather than Drive, of which all is used."""
        if is_shown:
            self.resizeDocks([self._drive], [self._drive.sizeHint().height()], Qt.Vertical)

    def _reset_layout(self) -> None:
        self._settings.reset_layout(self, self._scene.frame)

    def showEvent(self, event: QEvent) -> None:  # noqa: N802
        """Lets the Drive panel take the window's keys."""
        super().showEvent(event)
        self._drive.start()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        """Keeps the world framed while the view is resized; hides keys with modifiers from rviz.

        rviz ignores modifiers: Ctrl+A would spawn a model, as A does.
        """
        if event.type() == QEvent.Resize:
            self._scene.framing.follow_size()
        return event.type() == QEvent.KeyPress and bool(event.modifiers() & _OTHER_KEYS)

    def closeEvent(self, event: QEvent) -> None:  # noqa: N802
        """Ends the program, even if dialogs are open; asks first if there are unsaved changes.

        The layout is saved while it is whole.
        """
        if not self.is_closed and self._world_menu.keep_changes("closing", self._close_at_once):
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
        box.setStyleSheet("#qt_msgbox_informativelabel { min-width: 30em }")
        box.setTextFormat(Qt.PlainText)
        box.setInformativeText(why)
        box.setTextInteractionFlags(Qt.TextSelectableByMouse)
        box.setAttribute(Qt.WA_DeleteOnClose)
        box.open()

    def _show_keys(self) -> None:
        dialog = self.findChild(KeysDialog)
        if dialog is None:
            menus = [
                (action.text().replace("&", ""), rows_of(action.menu()))
                for action in self.menuBar().actions()
            ]
            tools = [(key_of(tool), tool.getName()) for tool in self._scene.tools if key_of(tool)]
            others = [("Tools", tools), ("Driving, in the Drive panel", DRIVING), ("Mouse", MOUSE)]
            dialog = KeysDialog(self, [menus, others])
        dialog.show()
        dialog.raise_()
        dialog.activateWindow()

    def _take_screenshot(self) -> None:
        QTimer.singleShot(_MENU_CLOSING_TIME, self._save_screenshot)  # without the menu in it

    def _save_screenshot(self) -> None:
        panel = self._scene.panel
        picture = panel.screen().grabWindow(panel.winId())  # including OpenGL content
        name = time.strftime("flatland_%Y-%m-%d_%H-%M-%S.png")
        start = str(Path.home() / name)
        file = ask_for_file(self, "Save a screenshot", start, "PNG (*.png)", is_new=True)
        if not file:
            return
        if picture.save(file) or picture.save(file, "PNG"):  # PNG for other endings
            self._line.show_message(f"Saved {file}")
        else:
            QMessageBox.warning(self, "Save a screenshot", f"{file} cannot be written.")
