"""The cases of Python programs, run with few steps."""

from pathlib import Path

import pytest

from flatland_benchmark import library_cases, plugin_cases
from flatland_benchmark.cases import CASES

WORLDS = Path(__file__).resolve().parents[3] / "flatland_server" / "worlds"


@pytest.mark.parametrize(
    "name", [name for name in CASES if name.startswith(("library_", "environment_"))]
)
def test_figures_of_programs(monkeypatch, name):
    if name.startswith("environment_"):
        pytest.importorskip("gymnasium")
    monkeypatch.setattr(library_cases, "_BLOCKS", 1)

    assert all(value > 0 for value in CASES[name].run(WORLDS).values())


def test_plugins_without_subscribers_cost_less_than_with_them(monkeypatch):
    monkeypatch.setattr(plugin_cases, "_BLOCKS", 2)

    figures = plugin_cases.measure_plugins(WORLDS)

    for name in ("Laser", "Imu", "Bumper", "BoolSensor"):
        assert figures[f"{name} idle [us]"] < figures[f"{name} heard [us]"] / 2
