"""The cases of robots and plugins in a Python program, run with few steps."""

import math
from pathlib import Path

import pytest

from flatland_benchmark import drive_cases, library_cases, plugin_cases

WORLDS = Path(__file__).resolve().parents[3] / "flatland_server" / "worlds"


@pytest.mark.parametrize("case", library_cases.LIBRARY_CASES, ids=lambda case: case.name)
def test_figures_of_the_library(monkeypatch, case):
    for name, value in (("_STEPS", 40), ("_BLOCKS", 1), ("_SIMULATIONS", 2), ("_ROUNDS", 1)):
        monkeypatch.setattr(library_cases, name, value)

    assert all(value > 0 for value in case.run(WORLDS).values())


def test_plugins_without_subscribers_cost_less_than_with_them(monkeypatch):
    monkeypatch.setattr(plugin_cases, "_BLOCKS", 2)

    figures = plugin_cases.measure_plugins(WORLDS)

    for name in ("Laser", "Imu", "Bumper", "BoolSensor"):
        assert figures[f"{name} idle [us]"] < figures[f"{name} heard [us]"] / 2


def test_the_office_is_the_one_that_is_shipped_with_other_beams():
    with library_cases.open_office(WORLDS, beams=64) as sim:
        robot = sim.models["turtlebot"]
        before = robot.pose
        sim.step(200)

        assert robot.sensors["laser"].read().shape == (64,)
        assert math.dist(robot.pose[:2], before[:2]) == pytest.approx(0.5, abs=0.05)


def test_driving_robots_meet(monkeypatch):
    monkeypatch.setattr(drive_cases, "_BLOCKS", 6)

    figures = drive_cases.drive(WORLDS, 10)

    assert figures["touches at a time"] > 0
    assert figures["step [us]"] > 0
