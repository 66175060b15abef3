"""The window's menus. They emit signals, and do nothing themselves."""

import math
from functools import partial
from pathlib import Path
from typing import Any, Callable, List, Optional

from python_qt_binding.QtCore import QObject, Signal
from python_qt_binding.QtGui import QKeySequence
from python_qt_binding.QtWidgets import QAction, QActionGroup, QDockWidget, QMenu, QMenuBar

from flatland_viz.scene import BACKGROUNDS
from flatland_viz.status import Simulation
from flatland_viz.world_files import label, model_files

_RATES = (0.1, 0.5, 1.0, 2.0, 5.0, 10.0, math.inf)


class Menus(QObject):
    """Fills a menu bar.

    Args:
        bar: the menu bar.
        docks: panels that the menus show and hide.
    """

    model_chosen = Signal(str)
    other_model_asked = Signal()
    screenshot_asked = Signal()
    reset_asked = Signal()
    quit_asked = Signal()
    pause_asked = Signal(bool)
    """True to pause, False to resume."""
    rate_chosen = Signal(float)
    background_chosen = Signal(str)

    def __init__(self, bar: QMenuBar, docks: List[QDockWidget]) -> None:
        super().__init__(bar)
        self._bar = bar
        self._world: Optional[Path] = None
        self._add_world_menu()
        self._add_simulation_menu()
        self._add_view_menu(docks)

    def _menu(self, parent: Any, text: str, name: str) -> QMenu:
        menu: QMenu = parent.addMenu(text)
        menu.setObjectName(name)
        return menu

    def _action(
        self, menu: QMenu, text: str, name: str, do: Callable[[], None], key: str = ""
    ) -> QAction:
        action = QAction(text, menu, objectName=name)
        action.triggered.connect(lambda checked: do())
        if key:
            action.setShortcut(QKeySequence(key))
        menu.addAction(action)
        return action

    def _add_world_menu(self) -> None:
        menu = self._menu(self._bar, "&World", "menu_world")
        self._models = self._menu(menu, "&Spawn model", "menu_spawn")
        self._models.aboutToShow.connect(self._list_models)
        self._other_model = self._action(
            menu,
            "Spawn &other...",
            "action_spawn_other",
            self.other_model_asked.emit,
            "Ctrl+O",
        )
        menu.addSeparator()
        self._action(
            menu,
            "Save s&creenshot...",
            "action_screenshot",
            self.screenshot_asked.emit,
            "Ctrl+S",
        )
        self._action(menu, "&Reset view", "action_reset_view", self.reset_asked.emit, "Home")
        menu.addSeparator()
        self._action(menu, "&Quit", "action_quit", self.quit_asked.emit, "Ctrl+Q")

    def _list_models(self) -> None:
        self._models.clear()
        for file in model_files(self._world) if self._world else []:
            name = label(file)
            action = self._action(
                self._models,
                name.replace("&", "&&"),
                f"action_spawn_{name}",
                partial(self.model_chosen.emit, str(file)),
            )
            action.setToolTip(str(file))
        if self._models.isEmpty():
            self._models.addAction("no models beside the world's file").setEnabled(False)

    def _add_simulation_menu(self) -> None:
        self._simulation = self._menu(self._bar, "&Simulation", "menu_simulation")
        self._pause = self._action(
            self._simulation, "&Pause", "action_pause", partial(self.pause_asked.emit, True)
        )
        self._resume = self._action(
            self._simulation, "&Resume", "action_resume", partial(self.pause_asked.emit, False)
        )
        menu = self._menu(self._simulation, "&Speed", "menu_speed")
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
        menu = self._menu(self._bar, "&View", "menu_view")
        backgrounds = QActionGroup(menu)
        choices = self._menu(menu, "&Background", "menu_background")
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
        for dock in docks:
            menu.addAction(dock.toggleViewAction())

    def set_world(self, path: str) -> None:
        """Sets the world's file, which determines the models to choose from."""
        self._world = Path(path)

    def show_simulation(self, simulation: Optional[Simulation]) -> None:
        """Enables the actions that apply to the present state; none if it is None."""
        self._simulation.setEnabled(simulation is not None)
        if simulation is None:
            return
        self._pause.setEnabled(not simulation.is_paused)
        self._resume.setEnabled(simulation.is_paused)
        for action in self._rates.actions():
            action.setChecked(action.data() == simulation.rate)

    def enable_spawning(self, can_spawn: bool) -> None:
        """Enables or disables spawning."""
        self._models.setEnabled(can_spawn)
        self._other_model.setEnabled(can_spawn)
