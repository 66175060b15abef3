"""Measures one simulator, in a process of its own, with the Python of its environment.

    python worker.py '{"module": "flatland_rooms", "kind": "Room", ...}' ANSWER

The module's `Room` and `Batch` have

    commands      a row for each of the scenario's, as `step` takes it
    step(row)     commands all robots, steps, and reads all scans
    scans()       the ranges of all lidars [m]

It writes an object with two numbers to the file ANSWER: `rate`, robot-steps per second of this
process's processor time, on all of its threads; and `wrong`, the share of wrong ranges before the
first step.
"""

import importlib
import itertools
import json
import sys
import time
from pathlib import Path
from typing import Any, Dict, Iterator, Mapping

from scenario import STEPS_PER_COMMAND, Scenario

CLOCK_PERIOD = 0.001
"""Interval between clock readings [s]; one reading can take a fifth of a step's time."""
WARM_UP = 0.2
"""Duration of the warm-up, as a share of the measurement's."""


def measure(
    module: str, kind: str, robots: int, seed: int, seconds: float, options: Mapping[str, Any]
) -> Dict[str, float]:
    """Opens a module's `Room`, or its `Batch` of a room for each robot, and measures it.

    Args:
        module: name of the module.
        kind: "Room" or "Batch".
        robots: number of robots.
        seed: of the scenario.
        seconds: processor time to measure for [s].
        options: further arguments of the room or the batch.
    """
    layout = Scenario(robots, seed, rooms=robots if kind == "Batch" else 1)
    room = getattr(importlib.import_module(module), kind)(layout, **options)
    wrong = layout.wrong_share(room.scans())
    commands = itertools.cycle([row for row in room.commands for _ in range(STEPS_PER_COMMAND)])
    _run(room, commands, WARM_UP * seconds)
    return {"rate": robots * _run(room, commands, seconds), "wrong": wrong}


def _run(room: Any, commands: Iterator[Any], seconds: float) -> float:
    """Steps a room for a time; returns steps per second."""
    steps, block, step, begin = 0, 1, room.step, time.process_time()
    while True:
        for row in itertools.islice(commands, block):
            step(row)
        steps += block
        spent = time.process_time() - begin
        if spent >= seconds:
            return steps / spent
        block = max(1, int(CLOCK_PERIOD * steps / spent))


if __name__ == "__main__":
    Path(sys.argv[2]).write_text(json.dumps(measure(**json.loads(sys.argv[1]))))
