"""Recordings that a signal or a full disk ends: they can be read up to there."""

import random
import signal
import subprocess
import sys
import time
from pathlib import Path

from soak.findings import Findings

from flatland2d.recording_file import read_recording

SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT)
LONGEST, LARGEST = 1.0, 3_000_000  # s until a signal, bytes until the disk is full
END_LIMIT = 20.0  # s
STEP = 5_000_000  # ns

PROGRAM = """
import resource, sys
from flatland2d import RecordingError, Simulation
sim = Simulation("office")
recorder = sim.record(sys.argv[1])
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[2]), -1))
print("begun", flush=True)
try:
    while True:
        sim.step()
except RecordingError:
    sim.step(10)
"""


def record_at_random(folder: Path, seed: int, count: int, findings: Findings) -> None:
    """Records in `count` processes, one after the other; each is ended by a signal or full disk."""
    folder.mkdir()
    for number in range(count):
        rng = random.Random(f"recording {seed} {number}")
        path = folder / f"{number}{rng.choice(['.bag', '.mcap'])}"
        is_full = rng.random() < 0.5
        size = rng.randrange(5_000, LARGEST) if is_full else -1
        process = subprocess.Popen(
            [sys.executable, "-c", PROGRAM, str(path), str(size)],
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )
        assert process.stdout is not None
        begun = process.stdout.readline()
        if not is_full:
            time.sleep(rng.uniform(0.0, LONGEST))  # the time of the signal is what is varied
            process.send_signal(rng.choice(SIGNALS))
        try:
            process.communicate(timeout=END_LIMIT)
        finally:
            process.kill()
        what = f"seed {seed}, recording {number} ({path.suffix}, {'full' if is_full else 'signal'})"
        if findings.expect(begun == b"begun\n", f"{what} has not begun"):
            _check(path, is_full, process.returncode, what, findings)
        findings.counts["recordings"] += 1


def _check(path: Path, is_full: bool, code: int, what: str, findings: Findings) -> None:
    """Checks that a recording has each step up to its end."""
    active = path.with_name(f"{path.name}.active")
    if is_full:
        findings.expect(code == 0, f"{what} has ended with {code}")
        findings.expect(not active.exists(), f"{what} is not complete")
    times = [
        message.nanoseconds
        for message in read_recording(path if path.exists() else active)
        if message.channel.topic == "/clock"
    ]
    expected = [max(index * STEP, 1 if path.suffix == ".bag" else 0) for index in range(len(times))]
    findings.expect(times == expected, f"{what} lacks steps")
    findings.counts["recorded steps"] += len(times)
