"""The start of a program and of the server: imports, and the time until a world runs."""

import os
import re
import resource
import subprocess
import sys
from pathlib import Path
from typing import Dict

from flatland_benchmark.case import Figures, case
from flatland_benchmark.server_process import ServerProcess

_ROUNDS = 10
"""Imports of each library; a figure is the least."""

_LIBRARIES = ("numpy", "flatland2d", "rospy", "flatland_server.ros.server")

_RUNNING = re.compile(r"^\[INFO\] \[(\d+\.\d+)[^\]]*\]: .*; running$", re.MULTILINE)
"""The line that the server logs before its first step, and its real time [s]."""


@case("start", "imports, and the server until it runs the office")
def measure_start(worlds: Path) -> Figures:
    """Processor time of imports, in processes of their own; real time until the office runs."""
    least: Dict[str, float] = {}
    for _ in range(_ROUNDS):
        for name in _LIBRARIES:
            least[name] = min(least.get(name, 1e9), _import(name))
    figures = {f"import {name} [s]": seconds for name, seconds in least.items()}
    with ServerProcess(worlds / "office" / "world.yaml", 200.0) as server:
        running = server.wait_until(lambda: _RUNNING.search(server.server.output), "its log")
    figures["the office runs [s]"] = float(running.group(1)) - server.started_at
    return figures


def _import(name: str) -> float:
    """Processor time of a process that imports a library [s]."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    subprocess.run([sys.executable, "-c", f"import {name}"], check=True, env=environment)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
