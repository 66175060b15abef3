"""Cases, run with few steps."""

from pathlib import Path

import pytest

from flatland_benchmark import gate_case, gym_cases, plugin_cases, sweep_cases
from flatland_benchmark.cases import CASES

WORLDS = Path(__file__).resolve().parents[3] / "flatland_server" / "worlds"


@pytest.mark.parametrize(
    "name", [name for name in CASES if name.startswith(("environment_", "training_"))]
)
def test_figures_of_environments(monkeypatch, name):
    pytest.importorskip("gymnasium")
    monkeypatch.setattr(gym_cases, "_BLOCKS", 1)
    monkeypatch.setattr(gym_cases, "_FIRST", 1)
    monkeypatch.setattr(gym_cases, "_MILLION", 2)
    for arguments in gym_cases._TRAININGS.values():
        monkeypatch.setitem(arguments, "num_envs", 2)

    assert all(value > 0 for value in CASES[name].run(WORLDS).values())


@pytest.mark.slow
def test_figures_of_workers(monkeypatch):
    pytest.importorskip("gymnasium")
    monkeypatch.setattr(sweep_cases, "_SCENARIOS", 3)
    monkeypatch.setattr(sweep_cases, "_STEPS", 1)

    for name in ("sweep_1", "rollouts_2"):
        assert all(value > 0 for value in CASES[name].run(WORLDS).values())


@pytest.mark.slow
def test_a_trial_of_the_gate(monkeypatch):
    monkeypatch.setattr(gate_case, "_SEEDS", 2)

    assert set(CASES["gate"].run(WORLDS).values()) == {0.0}  # with two seeds, a slower one, too


def test_plugins_without_subscribers_cost_less_than_with_them(monkeypatch):
    monkeypatch.setattr(plugin_cases, "_BLOCKS", 2)

    figures = plugin_cases.measure_plugins(WORLDS)

    for name in ("Laser", "Imu", "Bumper", "BoolSensor"):
        assert figures[f"{name} idle [us]"] < figures[f"{name} heard [us]"] / 2
