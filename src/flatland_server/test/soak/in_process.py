"""The parts of a soak that need no ROS master, in a process of their own, which may crash alone."""

import argparse
import json
import logging
import subprocess
import sys
import tempfile
from pathlib import Path

from soak.findings import Findings
from soak.random_files import RandomFiles
from soak.random_messages import send_random_messages
from soak.random_recordings import record_at_random
from soak.random_states import load_random_states
from soak.random_sweeps import read_random_scenario_files

FILES, STEPS, STATES, SCENARIO_FILES, RECORDINGS = 400, 400, 100, 100, 4
LIMIT = 120.0  # s


def run_in_process(seed: int, findings: Findings) -> None:
    """Reads spoilt files, sends random messages and records, in a new process."""
    result = subprocess.run(
        [sys.executable, "-X", "faulthandler", "-m", "soak.in_process", str(seed)],
        capture_output=True,
        text=True,
        timeout=LIMIT,
    )
    what = f"the process of seed {seed} has ended with {result.returncode}: {result.stderr[-3000:]}"
    if findings.expect(result.returncode == 0, what):
        findings.add(json.loads(result.stdout))


def main() -> None:
    """Prints the findings for a seed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("seed", type=int)
    seed = parser.parse_args().seed
    logging.disable(logging.CRITICAL)
    findings = Findings()
    with tempfile.TemporaryDirectory(prefix="flatland_soak_") as name:
        (Path(name) / "files").mkdir()
        RandomFiles(Path(name) / "files", seed, findings).run(FILES, LIMIT / 3)
        send_random_messages(Path(name) / "messages", seed, STEPS, findings)
        load_random_states(Path(name) / "states", seed, STATES, findings)
        read_random_scenario_files(Path(name) / "sweep", seed, SCENARIO_FILES, findings)
        record_at_random(Path(name) / "recordings", seed, RECORDINGS, findings)
    print(json.dumps(findings.to_dict()))


if __name__ == "__main__":
    main()
