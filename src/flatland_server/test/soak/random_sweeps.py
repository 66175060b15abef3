"""Sweeps with processes killed at random, misbehaving controllers and spoilt files.

Whatever happens, the tables of a sweep are those of a sweep that nothing has disturbed, to the
byte, and no process is left behind.
"""

import contextlib
import csv
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any, Callable, Dict, List, Tuple

from soak.findings import Findings
from soak.mutations import Mutator
from soak.random_files import READ_LIMIT
from waiting import wait_until

from flatland2d.sweep.scenario_file import read_scenario_file
from flatland2d.sweep.sweep import JOURNAL, read_entries
from flatland_server import FlatlandError

TABLES = ("results.csv", "summary.csv", "report.html")
LIMIT = 300.0  # s
Rows = Dict[Tuple[str, str], Dict[str, str]]
"""The rows of a table by controller and seed."""

_LEFT_OUT = ("matplotlib", "scipy")
"""Packages for figures and comparisons, which take longer than the sweeps: they are missing."""

_MARK = "FLATLAND_SOAK_SWEEP"
"""A variable in the environment of all processes that a sweep starts; its value is a folder."""

_FILES = {
    "world.yaml": """
properties: {}
layers: [{name: walls, map: walls.yaml}]
models: [{name: robot, model: robot.model.yaml}]
""",
    "walls.yaml": "{type: line_segments, data: walls.dat, scale: 1, origin: [0, 0, 0]}",
    "walls.dat": "-4 -4 4 -4\n4 -4 4 4\n4 4 -4 4\n-4 4 -4 -4\n",
    "robot.model.yaml": """
bodies: [{name: base, footprints: [{type: circle, radius: $eval 0.1 + 0.1, density: 10}]}]
plugins: [{type: DiffDrive, name: drive, body: base, odom_frame_id: odom}]
""",
}
_DRIVERS = r'''
import os, random, signal, subprocess, time


def towards(run):
    while run.is_running:
        run.robot.command(1.0 if abs(run.bearing) < 0.3 else 0.0, 3.0 * run.bearing)
        run.step()
    return {"process": "own", "draws": int(run.rng.integers(1000))}


def stay(*_):
    for number in set(signal.Signals) - {signal.SIGKILL, signal.SIGSTOP}:
        signal.signal(number, signal.SIG_IGN)
    time.sleep(1000)


def forks(run):
    """Both processes return; a third one and a program stay."""
    child = os.fork()
    if os.fork() == 0:
        stay()
    subprocess.Popen(["sleep", "1000"])
    result = towards(run)
    return {**result, "process": "own" if child else "child"}


def raises(run):
    run.step()
    raise ValueError(f"no text \ud800 {run.seed % 3}")


def write_everywhere():
    for number in range(3, 30):
        try:
            os.write(number, b"garbage" * 9)
        except OSError:
            pass


def open_others():
    os.closerange(3, 64)
    files.extend(open(os.devnull, "wb") for _ in range(30))


files = []
DEEDS = [
    lambda: os.fork(),
    lambda: os.fork() or stay(),
    lambda: os.fork() and os._exit(0),
    lambda: os.fork() or os.setsid() or os._exit(0),
    lambda: subprocess.Popen(["sleep", "1000"], close_fds=False),
    lambda: os.execvp("sleep", ["sleep", "1000"]),
    lambda: os.closerange(0, 64),
    lambda: signal.pthread_sigmask(signal.SIG_BLOCK, set(signal.Signals)),
    lambda: [signal.signal(number, signal.SIG_IGN) for number in range(1, 16) if number != 9],
    lambda: os.kill(os.getpid(), random.choice([9, 11, 15, 40])),
    lambda: os.kill(0, 15),
    open_others,
    write_everywhere,
]


def misbehaves(run):
    rng = random.Random(run.seed)
    for _ in range(rng.choice([1, 1, 2, 3])):
        rng.choice(DEEDS)()
    return towards(run)
'''
_SCENARIOS = """
worlds: [world.yaml]
controllers: [{controllers}]
seeds: {{first: {seed}, count: {count}}}
start: random
goal: random
goal_distance: [1, 3]
time_limit: 5
step_size: 0.02
control_period: 0.1
retries: {retries}
"""


def disturb_sweeps(
    folder: Path, seed: int, kills: int, findings: Findings, count: int = 60
) -> None:
    """Runs a sweep undisturbed, and again with kills, a damaged journal and bad controllers.

    Args:
        folder: folder for the files, which is created.
        seed: seed of the scenarios and of the disturbances.
        kills: number of times that processes are killed.
        findings: to which counts and violations are added.
        count: number of seeds of each controller.
    """
    rng = random.Random(f"sweeps {seed}")
    what = f"sweep of seed {seed}"
    _write_files(folder)
    _write_scenarios(folder, ["towards", "forks", "raises"], 10 * seed, count, retries=100)
    once = _start(folder, "once", jobs=1)
    findings.expect(once.wait(LIMIT) == 1, f"{what}: ended with {once.returncode}")

    _kill_at_random(folder, rng, kills, what, findings)
    _finish(folder, f"{what}, after kills", findings)
    _damage_journals(folder / "out" / JOURNAL, rng, what, findings)
    _finish(folder, f"{what}, with a damaged journal", findings)
    _write_scenarios(folder, ["towards", "misbehaves"], 10 * seed, count // 2, retries=0)
    process = _start(folder, "bad", jobs=2)
    findings.expect(process.wait(LIMIT) == 1, f"{what}, bad: ended with {process.returncode}")
    _expect_no_process(folder, f"{what}, with bad controllers", findings)
    _compare_rows(_rows(folder / "bad"), _rows(folder / "once"), what, findings)


def _kill_at_random(
    folder: Path, rng: random.Random, kills: int, what: str, findings: Findings
) -> None:
    """Kills processes of a sweep, which is started again when it was killed itself."""
    while kills and not (folder / "out" / "report.html").exists():
        process = _start(folder, "out", jobs=2)
        while kills and process.poll() is None:
            if rng.random() < 0.8:  # else while it starts
                _wait_for_results(folder, process)
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(rng.uniform(0.0, 0.5))
                break
            kills -= 1
            findings.counts["kills in sweeps"] += 1
            _kill(process, rng)
        process.wait(LIMIT)
        _expect_no_process(folder, what, findings)


def _damage_journals(journal: Path, rng: random.Random, what: str, findings: Findings) -> None:
    """Reads a journal damaged in many ways: what is read, is what was written."""
    original = journal.read_bytes()
    entries = {key: repr(entry) for key, entry in read_entries(journal).items()}
    mutator = Mutator(rng)
    for _ in range(100):
        journal.write_bytes(original)
        mutator.spoil(journal)
        findings.counts["damaged journals"] += 1
        try:
            found = read_entries(journal)
        except FlatlandError as error:
            findings.expect("is no journal" in str(error), f"{what}: {error}")
            continue
        false = [key for key, entry in found.items() if repr(entry) != entries.get(key)]
        findings.expect(not false, f"{what}: a damaged journal was believed: {false}")


def _compare_rows(found: Rows, good: Rows, what: str, findings: Findings) -> None:
    """Bad controllers fail or drive as the good one does; the rows of that are as before."""
    for (controller, seed), row in found.items():
        if row["status"] == "done":
            same = {**good["towards", seed], "controller": controller, "scenario": row["scenario"]}
            findings.expect(row == same, f"{what}: {row} is not {same}")
        else:
            findings.expect(controller == "misbehaves", f"{what}: {row}")
        findings.counts[f"rows of {controller} {row['status']}"] += 1


def _write_files(folder: Path) -> None:
    folder.mkdir()
    for name, text in {**_FILES, "drivers.py": _DRIVERS}.items():
        (folder / name).write_text(text)
    (folder / "left_out").mkdir()
    for name in _LEFT_OUT:
        (folder / "left_out" / f"{name}.py").write_text("raise ImportError('it is left out')\n")


def _write_scenarios(
    folder: Path, controllers: List[str], seed: int, count: int, retries: int
) -> None:
    entries = ", ".join(f'{{name: {name}, call: "drivers.py:{name}"}}' for name in controllers)
    text = _SCENARIOS.format(controllers=entries, seed=seed, count=count, retries=retries)
    (folder / "scenarios.yaml").write_text(text)


def _start(folder: Path, out: str, jobs: int) -> "subprocess.Popen[bytes]":
    command = f"sweep scenarios.yaml --out {out} --jobs {jobs} --pictures 2".split()
    paths = f"{folder / 'left_out'}{os.pathsep}{os.environ.get('PYTHONPATH', '')}"
    with (folder / f"{out}.log").open("ab") as log:
        return subprocess.Popen(
            [sys.executable, "-m", "flatland2d", *command],
            cwd=folder,
            env={**os.environ, "PYTHONPATH": paths, _MARK: str(folder)},
            stdout=log,
            stderr=log,
        )


def _wait_for_results(folder: Path, process: "subprocess.Popen[bytes]") -> None:
    """Waits until further scenarios are done, or the sweep has ended."""
    journal = folder / "out" / JOURNAL

    def count() -> int:
        return journal.read_bytes().count(b"\n") if journal.exists() else 0

    done = count()
    wait_until(lambda: count() > done + 1 or process.poll() is not None, "results", LIMIT)


def _kill(process: "subprocess.Popen[bytes]", rng: random.Random) -> None:
    """Kills a worker, the parent, or all of them at once."""
    workers = [pid for pid in _children(process.pid) if _name(pid) != "sh"]
    chosen = rng.choice([workers[:1], workers[-1:], [process.pid], [*workers, process.pid]])
    for pid in chosen:
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)


def _children(pid: int) -> List[int]:
    try:
        return [int(each) for each in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]
    except OSError:
        return []


def _name(pid: int) -> str:
    try:
        return Path(f"/proc/{pid}/comm").read_text().strip()
    except OSError:
        return ""


def _processes(folder: Path) -> List[int]:
    """The processes of sweeps in a folder."""
    mark, found = f"{_MARK}={folder}".encode(), []
    for path in Path("/proc").glob("[0-9]*/environ"):
        with contextlib.suppress(OSError):
            if mark in path.read_bytes().split(b"\0"):
                found.append(int(path.parent.name))
    return found


def _expect_no_process(folder: Path, what: str, findings: Findings) -> None:
    try:
        wait_until(lambda: not _processes(folder), "all processes to end")
    except AssertionError:
        left = {pid: _name(pid) for pid in _processes(folder)}
        findings.expect(False, f"{what}: processes are left: {left}")
        for pid in left:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)


def _finish(folder: Path, what: str, findings: Findings) -> None:
    """Runs the rest of a sweep, and compares its tables."""
    log = folder / "out.log"
    log.write_text("")
    _start(folder, "out", jobs=2).wait(LIMIT)
    _expect_no_process(folder, what, findings)
    text = log.read_text()
    findings.expect("Traceback" not in text, f"{what}: {text[-3000:]}")
    for name in TABLES if "is no journal" not in text else ():
        same = (folder / "out" / name).read_bytes() == (folder / "once" / name).read_bytes()
        findings.expect(same, f"{what}: {name} is not that of an undisturbed sweep")
        findings.counts["tables compared"] += 1


def _rows(folder: Path) -> Rows:
    """The rows of a table by controller and seed."""
    with (folder / "results.csv").open(newline="") as file:
        return {(row["controller"], row["seed"]): row for row in csv.DictReader(file)}


def read_random_scenario_files(folder: Path, seed: int, count: int, findings: Findings) -> None:
    """Reads spoilt scenario files: each is refused with its line or accepted, in bounded time."""
    rng = random.Random(f"scenario files {seed}")
    mutator = Mutator(rng)
    _write_files(folder)
    _write_scenarios(folder, ["towards", "forks"], seed, 5, retries=1)
    path = folder / "scenarios.yaml"
    text = path.read_text() + "parameters: {/a: [1, 2], models.robot.pose: [[0, 0, 0]]}\n"
    for number in range(count):
        path.write_text(text)
        mutator.spoil(path)
        what = f"seed {seed}, scenario file {number}"
        begin = time.monotonic()
        try:
            read_scenario_file(path)
            findings.counts["spoilt scenario files accepted"] += 1
        except FlatlandError as error:
            findings.expect(str(folder) in str(error), f"{what}: {error}")
            findings.counts["spoilt scenario files refused"] += 1
        except Exception as error:
            findings.expect(False, f"{what}: {error!r}")
        seconds = time.monotonic() - begin
        findings.expect(seconds < READ_LIMIT, f"{what}: took {seconds:.1f} s")


def soak_sweeps(
    folder: Path, seconds: float, seed: int, report: Callable[[str], None]
) -> Dict[str, Any]:
    """Disturbs sweeps for a time [s], in one round at least. Returns figures as a dict for JSON."""
    findings = Findings()

    def run_round(seed: int) -> None:
        with findings.part("random sweeps"):
            disturb_sweeps(folder / str(seed), seed, 10, findings)

    return findings.run_rounds(seconds, seed, run_round, report)
