"""Checks of the readings of a sensor by a program. Each yields the problems that it finds."""

from typing import Any, List

import numpy as np

from flatland_server.plugins.model_plugin import ModelPlugin
from flatland_server.testing.behaviour_checks import SECONDS, Problems, content_of, state_of
from flatland_server.testing.checked_plugin import ROBOT, CheckedPlugin, ObservedRun


def check_readings(case: CheckedPlugin) -> Problems:
    """Readings change nothing in the run, are equal at one time, and need no subscribers."""
    run = case.load(seed=7)
    if not _readings(run):
        return
    silent = case.load(seed=7).go(SECONDS)
    alone = case.load(seed=7, has_subscribers=False)
    for each in (run, alone):
        each.go(0.0)
    step = run.simulation.timekeeper.step_size
    for _ in range(round(SECONDS / step)):
        first, second = _readings(run), _readings(run)
        if first != second:
            yield f"expected equal readings at one time, found {first[0]} and {second[0]}"
            return
        if _readings(alone) != first:
            yield f"expected the same reading without subscribers, found {_readings(alone)[0]}"
            return
        run.simulation.run()
        alone.simulation.run()
    if content_of(run) != content_of(silent):
        yield "expected the same messages after readings, found a difference"
    if state_of(run) != state_of(silent):
        yield "expected the same poses and walls after readings, found a difference"


def _readings(run: ObservedRun) -> List["_Reading"]:
    """The present readings of the plugin; none if it is no sensor."""
    plugins: List[Any] = list(run.simulation.world.plugins_of(ROBOT).values())
    return [
        _Reading(read(run.simulation.timekeeper))
        for plugin in plugins
        if type(plugin).read is not ModelPlugin.read
        for read in (plugin.read, *(getattr(plugin, f"read_{each}") for each in plugin.quantities))
    ]


class _Reading:
    """A value that was read; equal to another one of the same bits, NaN included."""

    def __init__(self, value: Any) -> None:
        self._value = value
        # The string of an array takes milliseconds, and leaves out the middle of a long one.
        is_array = isinstance(value, np.ndarray)
        self._bits = (value.dtype, value.shape, value.tobytes()) if is_array else repr(value)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Reading) and self._bits == other._bits

    def __str__(self) -> str:
        return repr(self._value)
