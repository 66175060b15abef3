"""/diagnostics: the state of the simulation, and the plugins that have failed."""

from typing import Any, Dict, List

from flatland_server.messages import get, header
from flatland_server.plugins.plugin_manager import PluginFailure
from flatland_server.real_time_timer import RealTimeTimer
from flatland_server.simulation.simulation_manager import SimulationManager

DiagnosticArray = get("diagnostic_msgs/DiagnosticArray")
DiagnosticStatus = get("diagnostic_msgs/DiagnosticStatus")
KeyValue = get("diagnostic_msgs/KeyValue")

_PERIOD = 1.0
"""Seconds of real time between two messages, also while the simulation is paused."""


class Diagnostics:
    """Publishes the status of the simulation, and an error for each plugin switched off."""

    def __init__(self, manager: SimulationManager) -> None:
        self._manager = manager
        self._node = manager.transport.node_name.lstrip("/")
        self._publisher = manager.transport.advertise(
            "/diagnostics", DiagnosticArray, latch=False, queue_size=10
        )
        self._timer = RealTimeTimer(_PERIOD)

    def update(self) -> None:
        """Publishes if it is time to; to be called often."""
        if self._timer.check_update() and self._publisher.has_subscribers:
            failures = map(self._failure, self._manager.world.plugin_failures)
            stamp = header(self._manager.timekeeper.nanoseconds, "")
            self._publisher.publish(DiagnosticArray(stamp, [self._simulation(), *failures]))

    def _failure(self, failure: PluginFailure) -> Any:
        values = {"type": failure.type, "model": failure.owner or "(the world)"}
        text = f"switched off: {failure.reason}"
        return self._status(f"plugin {failure.label}", DiagnosticStatus.ERROR, text, values)

    def _simulation(self) -> Any:
        manager, world = self._manager, self._manager.world
        values: Dict[str, object] = {
            "simulated time [s]": f"{manager.timekeeper.seconds:.3f}",
            "times real time": f"{manager.pacer.real_time_factor:.2f}",
        }
        periods = sorted(manager.pacer.step_periods)
        if periods:
            values["step period, median [ms]"] = f"{_percentile(periods, 50) * 1e3:.3f}"
            values["step period, 99th percentile [ms]"] = f"{_percentile(periods, 99) * 1e3:.3f}"
        values["models"] = len(world.models)
        values["plugins"] = world.plugin_count
        values["plugins that failed"] = len(world.plugin_failures)
        text = "running" if manager.is_stepping else "paused"
        return self._status("simulation", DiagnosticStatus.OK, text, values)

    def _status(self, name: str, level: int, text: str, values: Dict[str, Any]) -> Any:
        pairs = [KeyValue(key, str(value)) for key, value in values.items()]
        return DiagnosticStatus(level, f"{self._node}: {name}", text, "none", pairs)


def _percentile(values: List[float], percent: int) -> float:
    """A percentile of sorted values."""
    return values[(len(values) - 1) * percent // 100]
