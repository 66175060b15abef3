"""A sweep in a small room: its files in a folder, and its settings."""

import sys
from pathlib import Path

import pytest

from flatland2d.sweep.scenario_file import read_scenario_file

WORLD = """
properties: {}
layers: [{name: walls, map: walls.yaml}]
models:
  - {name: robot, model: robot.model.yaml, pose: [-3, 0, 0]}
  - {name: box, model: box.model.yaml, pose: [0, 2, 0.3]}
"""
ROBOT = """
bodies: [{name: base, footprints: [{type: circle, radius: 0.2, density: 10}]}]
plugins:
  - {type: DiffDrive, name: drive, body: base, odom_frame_id: odom}
  - type: Laser
    name: laser
    body: base
    range: 5
    angle: {min: -1, max: 1, increment: 0.5}
    noise_std_dev: 0.01
"""
BOX = """
bodies:
  - name: box
    type: static
    footprints:
      - {type: polygon, points: [[-0.5, -0.3], [0.5, -0.3], [0.5, 0.3], [-0.5, 0.3]], density: 1}
"""
DRIVERS = '''
import enum
import gc
import os
import signal
import subprocess
import time
from multiprocessing.connection import Connection


def ahead(run, speed=0.5):
    while run.is_running:
        run.robot.command(speed, 0.0)
        run.step()


def towards(run, speed=1.0):
    """Turns to the goal, then drives there."""
    scan = 0.0
    while run.is_running:
        scan += float(run.robot.sensors["laser"].read().min())
        run.robot.command(speed if abs(run.bearing) < 0.3 else 0.0, 3.0 * run.bearing)
        run.step()
    return {"scan": scan, "draws": int(run.rng.integers(1000)), "note": "ok, so"}


def dies_once(run, mark):
    """Is killed by SIGKILL in its first attempt."""
    if run.seed == 2 and not os.path.exists(mark):
        open(mark, "w").close()
        os.kill(os.getpid(), signal.SIGKILL)
    towards(run)


def dies(run):
    os.kill(os.getpid(), signal.SIGSEGV)


def hangs(run):
    time.sleep(1000)


def fails(run):
    run.step()
    return 1 / 0


def forks(run):
    """Both processes return; a program stays."""
    child = os.fork()
    if child:
        stay()
    return {**towards(run), "note": "own" if child else "of the child"}


def stay():
    with open("stay", "a") as file:
        print(subprocess.Popen(["sleep", "1000"]).pid, file=file)


def forges(run):
    """Sends the parent answers of others."""
    [connection] = [each for each in gc.get_objects() if isinstance(each, Connection)]
    for process, number in ((os.getpid(), 9), (1, run.seed + 1)):
        connection.send((process, number, None))
    return towards(run)


def stops(run):
    stay()
    os.kill(os.getpid(), signal.SIGSTOP)


def knocks(run):
    """Drives against the wall behind twice, and believes to be 10 and then 40 cm beside."""
    for speed, turn, error in ((-1.0, 0.0, 0.1), (0.5, 0.2, 0.1), (-1.0, 0.0, 0.4)):
        run.robot.command(speed, turn)
        run.step(1.5)
        run.note_estimate(run.robot.pose.x, run.robot.pose.y + error)


def strays(run, y):
    run.note_estimate(0.0, float(y))


class Word(str, enum.Enum):
    A = "a"


def odd(run):
    run.step()
    if run.seed == 1:
        raise ValueError("no text: \\ud800")
    return {"word": Word.A, "text": "\\udfff", "x": 1e308, "n": 10 ** (400 * (run.seed == 2))}
'''
SCENARIOS = """
worlds: [world.yaml]
controllers: [{name: towards, call: "drivers.py:towards"}]
seeds: 4
start: random
goal: random
goal_distance: [1, 3]
time_limit: 5
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """The files of a sweep, and the working directory. Sweeps in this process draw no figure."""
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    files = {
        "world.yaml": WORLD,
        "walls.yaml": "{type: line_segments, data: walls.dat, scale: 1, origin: [0, 0, 0]}",
        "walls.dat": "-4 -4 4 -4\n4 -4 4 4\n4 4 -4 4\n-4 4 -4 -4\n",
        "robot.model.yaml": ROBOT,
        "box.model.yaml": BOX,
        "drivers.py": DRIVERS,
        "scenarios.yaml": SCENARIOS,
    }
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def settings_of(folder):
    """Reads a scenario file: that of the folder, with some keys replaced or added."""

    def read(**keys):
        path = folder / "scenarios.yaml"
        lines = [line for line in SCENARIOS.strip().splitlines() if line.split(":")[0] not in keys]
        lines += [f"{key}: {value}" for key, value in keys.items() if value is not None]
        path.write_text("\n".join(lines) + "\n")
        return read_scenario_file(Path(path))

    return read
