"""Processes that multiprocessing has spawned find the package, as catkin has built it."""

import json
import subprocess
import sys

import pytest


def test_a_spawned_process_can_import_what_this_one_has_imported():
    # A spawned process first runs multiprocessing.spawn.prepare(), and then the function.
    program = "import json, sys; sys.path[:] = json.loads(sys.argv[1]); import flatland_server"
    result = subprocess.run(
        [sys.executable, "-c", program, json.dumps(sys.path)],
        stderr=subprocess.PIPE,
        text=True,
        timeout=60,
    )
    assert result.returncode == 0, result.stderr


STEPPING = """
import threading
import numpy as np
from flatland2d import Simulation, SimulationBatch

def step_on():
    while True:
        step()
        has_begun.set()

has_begun = threading.Event()
{}
threading.Thread(target=step_on, daemon=True).start()
has_begun.wait()
"""


@pytest.mark.parametrize(
    "made",
    [
        "step = Simulation('office').step",
        "batch = SimulationBatch('test_room', 2); step = lambda: batch.step(np.zeros((2, 2)))",
    ],
    ids=["simulation", "batch"],
)
def test_a_process_may_end_while_a_thread_steps(made):
    command = [sys.executable, "-c", STEPPING.format(made)]
    ended = subprocess.run(command, stderr=subprocess.PIPE, text=True, timeout=60)
    assert (ended.returncode, ended.stderr) == (0, "")
