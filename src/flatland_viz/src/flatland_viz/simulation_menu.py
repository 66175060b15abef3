"""The menu Simulation: pauses, steps, goes back in time, and sets the rate."""

import math
from functools import partial
from typing import Optional

from python_qt_binding.QtWidgets import QInputDialog, QMenu, QWidget

from flatland_viz.actions import add_action
from flatland_viz.services import Services
from flatland_viz.settings import Settings
from flatland_viz.status import Simulation

_STEPS = "steps"
_UNLIMITED = "as fast as possible"
_RATES = ("0.1", "0.5", "1", "2", "5", "10", _UNLIMITED)
_SEEKS = (
    ("&Back 10 s", -10.0, "Alt+Left"),
    ("&Forward 10 s", 10.0, "Alt+Right"),
    ("To the &latest time", math.inf, "Alt+End"),
)
"""Moves in the history: text, how far [s], and key."""


class SimulationMenu(QMenu):
    """Acts on simulated time.

    Args:
        window: the parent of dialogs.
        services: services of the server.
        settings: settings, which keep the number of steps.
    """

    def __init__(self, window: QWidget, services: Services, settings: Settings) -> None:
        super().__init__("&Simulation", window)
        self.setToolTipsVisible(True)
        self._window = window
        self._services = services
        self._settings = settings
        self._simulation: Optional[Simulation] = None
        self._pause = add_action(self, "", services.toggle_pause)
        self.step = add_action(
            self, "&Step", partial(services.step, 1), "F10", "Make one step, while paused"
        )
        self.step.setAutoRepeat(True)
        self._steps = add_action(self, "S&teps...", self._ask_for_steps, "Shift+F10")
        self.addSeparator()
        self._seeks = [
            add_action(self, text, partial(self._seek, seconds), key)
            for text, seconds, key in _SEEKS
        ]
        self.addSeparator()
        add_action(self, "&Rate...", self.ask_for_rate)
        self.show_simulation(None)

    def show_simulation(self, simulation: Optional[Simulation]) -> None:
        """Enables the actions that apply to the present state; none if it is None."""
        self._simulation = simulation
        is_paused = simulation is not None and simulation.is_paused
        self._pause.setText("&Resume\tSpace" if is_paused else "&Pause\tSpace")
        for action in self.actions():
            action.setEnabled(simulation is not None)
        self.step.setEnabled(is_paused)
        self._steps.setEnabled(is_paused)
        if simulation is not None:
            for action, (_, seconds, _) in zip(self._seeks, _SEEKS):
                edge = simulation.begin if seconds < 0 else simulation.end
                action.setEnabled(simulation.end > simulation.begin and simulation.time != edge)

    def _seek(self, seconds: float) -> None:
        """Goes back, if it is negative, or on within the run."""
        if self._simulation is not None:
            begin, end = self._simulation.begin, self._simulation.end
            self._services.seek(min(max(self._simulation.time + seconds, begin), end))

    def _ask_for_steps(self) -> None:
        before = int(self._settings.number(_STEPS, 100))
        count, is_given = QInputDialog.getInt(
            self._window, "Steps", "&Steps:", before, 1, 1_000_000
        )
        if is_given:
            self._settings.set_number(_STEPS, count)
            self._services.step(count)

    def ask_for_rate(self) -> None:
        """Asks for the rate of the simulation, of which the present one is proposed."""
        if self._simulation is None:
            return
        rate = self._simulation.rate
        present = f"{rate:g}" if math.isfinite(rate) else _UNLIMITED
        choices = [present, *(each for each in _RATES if each != present)]
        text, is_given = QInputDialog.getItem(
            self._window, "Change Rate", "&Times real time:", choices, 0, True
        )
        if is_given:
            self._services.change_rate(rate_of(text))


def rate_of(text: str) -> float:
    """The rate that a text stands for; NaN, which the server refuses, for no number."""
    if text.strip() == _UNLIMITED:
        return math.inf
    try:
        return float(text.replace(",", "."))
    except ValueError:
        return math.nan
