"""Sweeps under kills, with bad controllers and spoilt files: a short soak."""

import pytest
from soak.findings import Findings
from soak.random_sweeps import disturb_sweeps, read_random_scenario_files

SEED = 1
KILLS, COUNT, FILES = 3, 20, 100

pytestmark = pytest.mark.slow


def test_the_tables_of_a_disturbed_sweep_are_those_of_another(tmp_path):
    findings = Findings()

    disturb_sweeps(tmp_path / "sweep", SEED, KILLS, findings, COUNT)

    assert findings.violations == []
    assert findings.counts["kills in sweeps"] > 0
    assert findings.counts["rows of misbehaves failed"] > 0


def test_a_spoilt_scenario_file_is_read_or_refused(tmp_path):
    findings = Findings()

    read_random_scenario_files(tmp_path / "files", SEED, FILES, findings)

    assert findings.violations == []
    assert findings.counts["spoilt scenario files refused"] > FILES / 4
    assert findings.counts["spoilt scenario files accepted"] > FILES / 20
