"""Measures one simulator, in a process of its own, with the Python of its environment.

    python worker.py flatland_rooms|irsim_rooms

It reads requests from its input, a JSON object a line, and answers each with a line:

    {"kind": "room", "variant": "", "robots": 10, "seed": 1, "seconds": 0.5}
    {"ranges": [[...]], "rate": 1000.0}     the first scans [m], and robot-steps per second

A rate is per second of this process's processor time, on all of its threads.
"""

import importlib
import json
import os
import sys
import time
from typing import Any, Dict

CLOCK_PERIOD = 0.001
"""Interval between clock readings [s]; one reading can take a fifth of a step's time."""
WARM_UP = 0.2
"""Duration of the warm-up, as a share of the measurement's."""


def measure(rooms: Any, seconds: float, **arguments: Any) -> Dict[str, Any]:
    """Opens a room by the module's `open_room` with these arguments, measures it, and closes it."""
    room = rooms.open_room(**arguments)
    ranges = [[float(value) for value in scan] for scan in room.scans()]
    _run(room, WARM_UP * seconds)
    rate = _run(room, seconds)
    room.close()
    return {"ranges": ranges, "rate": rate}


def _run(room: Any, seconds: float) -> float:
    """Steps a room for a time; returns robot-steps per second."""
    steps, block, begin = 0, 1, time.process_time()
    while True:
        room.run(block)
        steps += block
        spent = time.process_time() - begin
        if spent >= seconds:
            return steps * float(room.robots) / spent
        block = max(1, int(CLOCK_PERIOD * steps / spent))


if __name__ == "__main__":
    to_parent = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # keeps what simulators and their libraries print out of the answers
    opened = importlib.import_module(sys.argv[1])
    for line in sys.stdin:
        print(json.dumps(measure(opened, **json.loads(line))), file=to_parent, flush=True)
