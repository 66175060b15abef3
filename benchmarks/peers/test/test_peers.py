"""The comparison with peers: a small run without them, its table, and its arithmetic."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from compare import Case, table
from scenario import DISC_RADIUS, Scenario, squares
from simulators import FLATLAND, IRSIM

HERE = Path(__file__).resolve().parents[1]


def cells(line):
    """The cells of a row of a table."""
    return [cell.strip() for cell in line.strip("|").split("|")]


@pytest.mark.slow
def test_a_small_run_prints_what_it_has_measured():
    command = [sys.executable, str(HERE / "compare.py"), "--alone", "--rounds", "2"]
    command += ["--seconds", "0.01", "--robots", "1", "3", "--batch", "4"]
    run = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60)

    head, _, flatland, substeps, ratio = map(cells, run.stdout.splitlines())
    assert head[1:] == ["robots 1", "robots 3", "batch 4", "wrong ranges [%]"]
    for name, *rates, wrong in (flatland, substeps):
        assert name.startswith("Flatland")
        assert all(float(rate.replace(",", "")) > 0 for rate in rates)
        assert float(wrong) == 0.0
    assert ratio[0] == "times Flatland, 20 x 5 ms"


def test_ratios_are_those_of_rounds():
    room, batch = Case("Room", 10), Case("Batch", 1024)
    rates = {
        (FLATLAND.name, room): [300.0, 900.0, 500.0],
        (FLATLAND.name, batch): [5.0],
        (IRSIM.name, room): [1.0, 2.0, 5.0],
    }

    *_, peer, ratio = map(cells, table([room, batch], rates, {}))

    assert peer == ["ir-sim 2.12.0", "2", "", ""]
    assert ratio == ["times ir-sim 2.12.0", "300", "", ""]


def test_wrong_ranges_are_counted():
    scenario = Scenario(2, seed=3)
    exact = scenario.exact_ranges()
    assert 0.0 < np.mean(exact < 10.0) < 1.0
    ranges = exact.copy()
    ranges[0, :3] += (0.009, 0.011, np.nan)

    assert scenario.wrong_share(ranges.tolist()) == 2 / 128


def test_a_map_of_squares_has_the_room_and_its_discs():
    discs = np.array([[10.0, 20.0]])

    fine, coarse = squares(discs, 0.1), squares(discs, 1.0)

    assert fine.shape == (402, 402)
    assert fine[0].all()
    assert fine[:, -1].all()
    assert 0.01 * fine[1:-1, 1:-1].sum() == pytest.approx(np.pi * DISC_RADIUS**2, rel=0.05)
    assert fine[201, 101]  # row: y, after the border
    assert np.argwhere(coarse[1:-1, 1:-1]).tolist() == [[20, 10]]
