"""The window's menus. They only emit signals.

A key after a tab in an action's text belongs to a tool of rviz, and is only shown.
"""

import math
from functools import partial
from typing import Any, Callable, List, Optional, Tuple

from python_qt_binding.QtCore import QObject, Signal
from python_qt_binding.QtGui import QKeySequence
from python_qt_binding.QtWidgets import (
    QAction,
    QActionGroup,
    QDockWidget,
    QMenu,
    QMenuBar,
    QToolBar,
)

from flatland_viz.recent_worlds import RecentMenu
from flatland_viz.scene import BACKGROUNDS
from flatland_viz.settings import Settings
from flatland_viz.status import Simulation

_RATES = (0.1, 0.5, 1.0, 2.0, 5.0, 10.0, math.inf)

_SEEKS = (
    ("&Back 10 s", "action_back", -10.0, "Alt+Left"),
    ("&Forward 10 s", "action_forward", 10.0, "Alt+Right"),
    ("To the &latest time", "action_latest", math.inf, "Alt+End"),
)
"""Moves in the history: text, name, how far [s], and key."""


class Menus(QObject):
    """Fills a menu bar.

    Args:
        bar: the menu bar.
        docks: panels that the menus show and hide.
        settings: settings, which keep the switches.
    """

    world_chosen = Signal(str)
    other_world_asked = Signal()
    reload_asked = Signal()
    world_reset_asked = Signal()
    save_asked = Signal()
    save_as_asked = Signal()
    step_asked = Signal()
    steps_asked = Signal()
    seek_asked = Signal(float)
    """Step within the history [s]; negative ones go back."""
    keys_asked = Signal()
    spawn_asked = Signal()
    screenshot_asked = Signal()
    reset_asked = Signal()
    layout_reset_asked = Signal()
    quit_asked = Signal()
    pause_asked = Signal(bool)
    """True to pause, False to resume."""
    rate_chosen = Signal(float)
    background_chosen = Signal(str)

    def __init__(self, bar: QMenuBar, docks: List[QDockWidget], settings: Settings) -> None:
        super().__init__(bar)
        self._bar = bar
        self._recent = RecentMenu(settings)
        self._add_world_menu()
        self._add_simulation_menu()
        self._add_view_menu(docks)
        self._add_help_menu()

    def _menu(self, parent: Any, text: str, name: str) -> QMenu:
        menu: QMenu = parent.addMenu(text)
        menu.setObjectName(name)
        menu.setToolTipsVisible(True)
        return menu

    def _action(
        self, menu: QMenu, text: str, name: str, do: Callable[[], None], key: str = ""
    ) -> QAction:
        action = QAction(text, menu, objectName=name)
        action.triggered.connect(lambda checked: do())
        action.setAutoRepeat(False)
        if key:
            action.setShortcut(QKeySequence(key))
        menu.addAction(action)
        return action

    def _add_world_menu(self) -> None:
        menu = self._menu(self._bar, "&World", "menu_world")
        opens = self._action(menu, "&Open...", "action_open", self.other_world_asked.emit, "Ctrl+O")
        menu.addMenu(self._recent)
        self._recent.chosen.connect(self.world_chosen)
        reload = self._action(menu, "Re&load files", "action_reload", self.reload_asked.emit, "F5")
        reload.setToolTip("After an edit: loads the world's files again; time goes on.")
        menu.addSeparator()
        self.reset = self._action(
            menu, "Re&set", "action_reset", self.world_reset_asked.emit, "Ctrl+R"
        )
        self.reset.setToolTip("Start again: the world as it was loaded; time goes on (Ctrl+R)")
        self._with_server = [opens, self._recent, reload, self.reset]
        menu.addSeparator()
        self.save = self._action(menu, "Sa&ve", "action_save", self.save_asked.emit, "Ctrl+S")
        self.save.setToolTip("Moved, spawned and deleted models, into the world's file (Ctrl+S)")
        save_as = self._action(
            menu, "Save &as...", "action_save_as", self.save_as_asked.emit, "Ctrl+Shift+S"
        )
        save_as.setToolTip("The same, into a new file")
        self._with_server.append(save_as)
        menu.addSeparator()
        self._spawn = self._action(
            menu, "S&pawn model...\tA", "action_spawn", self.spawn_asked.emit
        )
        menu.addSeparator()
        self._action(
            menu, "Save s&creenshot...", "action_screenshot", self.screenshot_asked.emit, "Ctrl+P"
        )
        self._action(
            menu, "Show the &whole world", "action_reset_view", self.reset_asked.emit, "Home"
        )
        menu.addSeparator()
        self._action(menu, "&Quit", "action_quit", self.quit_asked.emit, "Ctrl+Q")

    def _add_simulation_menu(self) -> None:
        self._simulation = self._menu(self._bar, "&Simulation", "menu_simulation")
        self._pause = self._action(
            self._simulation, "&Pause", "action_pause", partial(self.pause_asked.emit, True)
        )
        self._resume = self._action(
            self._simulation, "&Resume", "action_resume", partial(self.pause_asked.emit, False)
        )
        for action in (self._pause, self._resume):
            action.setText(f"{action.text()}\tSpace")
        self._simulation.addSeparator()
        self.step = self._action(
            self._simulation, "&Step", "action_step", self.step_asked.emit, "F10"
        )
        self.step.setAutoRepeat(True)
        self.step.setToolTip("Make one step (F10), while paused")
        self._steps = self._action(
            self._simulation, "S&teps...", "action_steps", self.steps_asked.emit, "Shift+F10"
        )
        self._simulation.addSeparator()
        self._seeks = [
            self._action(self._simulation, text, name, partial(self.seek_asked.emit, seconds), key)
            for text, name, seconds, key in _SEEKS
        ]
        self._simulation.addSeparator()
        menu = self._menu(self._simulation, "&Rate", "menu_speed")
        self._rates = QActionGroup(menu)
        for rate in _RATES:
            text = f"{rate:g} x real time" if math.isfinite(rate) else "as fast as possible"
            action = self._action(
                menu, text, f"action_rate_{rate:g}", partial(self.rate_chosen.emit, rate)
            )
            action.setCheckable(True)
            action.setData(rate)
            self._rates.addAction(action)
        self.show_simulation(None)

    def _add_view_menu(self, docks: List[QDockWidget]) -> None:
        self.view = menu = self._menu(self._bar, "&View", "menu_view")
        backgrounds = QActionGroup(menu)
        choices = self._menu(menu, "&Colours", "menu_background")
        for name in BACKGROUNDS:
            action = self._action(
                choices,
                f"&{name.capitalize()}",
                f"action_background_{name}",
                partial(self.background_chosen.emit, name),
            )
            action.setCheckable(True)
            action.setChecked(name == "light")
            backgrounds.addAction(action)
        menu.addSeparator()
        self._first_panel = docks[0].toggleViewAction()
        for dock in docks:
            menu.addAction(dock.toggleViewAction())
        self._action(menu, "Reset &layout", "action_reset_layout", self.layout_reset_asked.emit)

    def add_toolbar(self, toolbar: QToolBar) -> None:
        """Adds an action that shows and hides a toolbar, above those of panels."""
        action = toolbar.toggleViewAction()
        action.setText("&Toolbar")
        action.setObjectName("")  # its state is part of the layout
        self.view.insertAction(self._first_panel, action)

    def _add_help_menu(self) -> None:
        menu = self._menu(self._bar, "&Help", "menu_help")
        self._action(menu, "&Keys and mouse", "action_keys", self.keys_asked.emit, "F1")

    @property
    def titled(self) -> List[Tuple[str, QMenu]]:
        """The menus of the bar, with their titles."""
        actions = self._bar.actions()
        return [(action.text().replace("&", ""), action.menu()) for action in actions]

    def set_world(self, path: str) -> None:
        """Sets the world's file."""
        self._recent.add(path)

    def show_simulation(self, simulation: Optional[Simulation]) -> None:
        """Enables the actions that apply to the present state; none if it is None."""
        self._simulation.setEnabled(simulation is not None)
        for each in self._with_server:
            each.setEnabled(simulation is not None)
        is_paused = simulation is not None and simulation.is_paused
        self.step.setEnabled(is_paused)
        self._steps.setEnabled(is_paused)
        if simulation is None:
            return
        for action, (_, _, seconds, _) in zip(self._seeks, _SEEKS):
            edge = simulation.begin if seconds < 0 else simulation.end
            action.setEnabled(simulation.end > simulation.begin and simulation.time != edge)
        self._pause.setEnabled(not simulation.is_paused)
        self._resume.setEnabled(simulation.is_paused)
        for action in self._rates.actions():
            action.setChecked(action.data() == simulation.rate)

    def enable_spawning(self, can_spawn: bool) -> None:
        """Enables or disables spawning."""
        self._spawn.setEnabled(can_spawn)
