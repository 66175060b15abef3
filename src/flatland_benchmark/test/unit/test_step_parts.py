"""Time of a step by part: each part is measured."""

from pathlib import Path

import pytest

from flatland_benchmark.robot_worlds import write_world
from flatland_benchmark.step_parts import Stopwatch, measure
from flatland_server import _core

WORLDS = Path(__file__).resolve().parents[3] / "flatland_server" / "worlds"


class Clock:
    def __init__(self):
        self.now = 0.0

    def perf_counter(self):
        return self.now


def test_times_of_nested_parts_are_exclusive(monkeypatch):
    clock = Clock()
    monkeypatch.setattr("flatland_benchmark.step_parts.time", clock)
    stopwatch = Stopwatch()

    def inner():
        clock.now += 2.0

    timed_inner = stopwatch.timed("inner", inner)

    def outer():
        clock.now += 1.0
        timed_inner()
        clock.now += 4.0

    stopwatch.timed("outer", outer)()
    clock.now += 8.0
    timed_inner()

    assert stopwatch.seconds == {"outer": 5.0, "inner": 4.0}


@pytest.mark.parametrize("is_subscribed", [False, True])
def test_every_part_is_measured(tmp_path, is_subscribed):
    physics, scan = _core.World, _core.Lidar.scan

    seconds = measure(write_world(tmp_path, WORLDS, 2), is_subscribed, steps=40)

    assert list(seconds) == ["step", "physics", "scans", "plugins", "publishing", "markers"]
    assert (seconds.pop("markers") > 0.0) == is_subscribed
    assert all(value > 0.0 for value in seconds.values())
    assert _core.World is physics
    assert _core.Lidar.scan is scan
