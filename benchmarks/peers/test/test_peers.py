"""The comparison with peers: a small run without them, its output, and its arithmetic."""

import json
import subprocess
import sys
from pathlib import Path

import jsonschema
import numpy as np
import pytest

from comparison import Comparison, to_markdown
from scenario import Scenario
from simulators import FLATLAND, IRSIM, IRSIM_X, SIMULATORS, Case

HERE = Path(__file__).resolve().parents[1]


def validate(text):
    """Validates a report against the schema; returns its content."""
    values = json.loads(text)
    jsonschema.validate(values, json.loads((HERE / "peers.schema.json").read_text()))
    return values


@pytest.mark.slow
def test_a_small_run_writes_what_it_has_measured(tmp_path):
    files = [tmp_path / "peers.json", tmp_path / "peers.md"]
    command = [sys.executable, str(HERE / "compare.py"), "--alone", "--rounds", "2"]
    command += ["--seconds", "0.01", "--robots", "1", "3", "--batch", "4", "--crowd", "5"]
    command += ["--json", str(files[0]), "--markdown", str(files[1])]
    run = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60)

    values = validate(files[0].read_text())
    cases = values["simulators"]["Flatland"]["cases"]
    assert list(cases) == ["robots_1", "robots_3", "batch_4", "crowd_5"]
    assert all(len(case["values"]) == 2 for case in cases.values())
    assert [case["wrong ranges"] for case in cases.values()] == [0.0, None, 0.0, None]
    assert "| Flatland | " in files[1].read_text()
    assert "Flatland, batch of 4: 0 %" in run.stdout


def test_ratios_are_those_of_rounds():
    cases = [Case("room", 10), Case("batch", 1024)]
    comparison = Comparison(SIMULATORS, cases)
    for ours, theirs in ((300.0, 1.0), (900.0, 2.0), (500.0, 5.0)):
        comparison.add(FLATLAND, cases[0], ours)
        comparison.add(IRSIM, cases[0], theirs)
    comparison.add(FLATLAND, cases[1], 5.0)
    comparison.add(IRSIM_X, cases[1], 2.0)

    values = validate(comparison.to_json())
    assert values["ratios"]["ir-sim"] == {"robots_10": 300.0}
    assert [(each["case"], each["is_met"]) for each in values["targets"]] == [
        ("robots_10", True),
        ("batch_1024", False),
    ]
    assert "| Flatland, times irsim-x | - | 2.5 |" in to_markdown(comparison.rows())


def test_wrong_ranges_are_counted():
    case, layout = Case("room", 2), Scenario(2, seed=3)
    comparison = Comparison(SIMULATORS, [case])
    ranges = layout.exact_ranges()
    assert 0.0 < np.mean(ranges < 10.0) < 1.0
    ranges[0, :3] += (0.009, 0.011, np.nan)
    comparison.check(IRSIM, case, ranges.tolist(), layout)

    assert comparison.wrong_share(IRSIM, case) == 2 / 128
    assert comparison.wrong_share(FLATLAND, case) is None
