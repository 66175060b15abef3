"""/diagnostics: the state of the simulation, and the plugins that have failed."""

from typing import Any, Dict, List

import diagnostic_updater
from diagnostic_msgs.msg import DiagnosticStatus

from flatland_server.plugins.plugin_manager import PluginFailure
from flatland_server.real_time_timer import RealTimeTimer
from flatland_server.simulation.simulation_manager import SimulationManager

_PERIOD = 1.0
"""Seconds of real time between two messages, also while the simulation is paused."""


class _Updater(diagnostic_updater.Updater):
    """The library's Updater without its extra message "starting up" for each new status."""

    def addedTaskCallback(self, task: Any) -> None:  # noqa: N802 (the library's name)
        pass


class Diagnostics:
    """Publishes the status of the simulation, and an error for each plugin switched off."""

    def __init__(self, manager: SimulationManager) -> None:
        self._manager = manager
        self._updater = _Updater()
        self._updater.setHardwareID("none")
        self._updater.add("simulation", self._report_simulation)
        self._failures: Dict[str, PluginFailure] = {}
        self._timer = RealTimeTimer(_PERIOD)

    def update(self) -> None:
        """Publishes if it is time to; to be called often."""
        if self._timer.check_update():
            self._follow_failures()
            self._updater.force_update()

    def _follow_failures(self) -> None:
        failures = {f"plugin {each.label}": each for each in self._manager.world.plugin_failures}
        for name in self._failures.keys() - failures.keys():
            self._updater.removeByName(name)
        for name in failures.keys() - self._failures.keys():
            self._updater.add(name, self._reporter_of(failures[name]))
        self._failures = failures

    def _reporter_of(self, failure: PluginFailure) -> Any:
        def report(status: Any) -> Any:
            status.summary(DiagnosticStatus.ERROR, f"switched off: {failure.reason}")
            status.add("type", failure.type)
            status.add("model", failure.owner or "(the world)")
            return status

        return report

    def _report_simulation(self, status: Any) -> Any:
        manager, world = self._manager, self._manager.world
        status.summary(DiagnosticStatus.OK, "running" if manager.is_stepping else "paused")
        status.add("simulated time [s]", f"{manager.timekeeper.seconds:.3f}")
        status.add("times real time", f"{manager.real_time_factor:.2f}")
        periods = sorted(manager.step_periods)
        if periods:
            status.add("step period, median [ms]", f"{_percentile(periods, 50) * 1e3:.3f}")
            status.add("step period, 99th percentile [ms]", f"{_percentile(periods, 99) * 1e3:.3f}")
        status.add("models", len(world.models))
        status.add("plugins", world.plugin_count)
        status.add("plugins that failed", len(world.plugin_failures))
        return status


def _percentile(values: List[float], percent: int) -> float:
    """A percentile of sorted values."""
    return values[(len(values) - 1) * percent // 100]
