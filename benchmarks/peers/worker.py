"""Measures one simulator, in a process of its own, with the Python of its environment.

    python worker.py flatland_rooms|irsim_rooms

It reads requests from its input, a JSON object a line, and answers each with a line:

    {"open": "room", "variant": "", "robots": 10, "seed": 1}
                                     opens a room; {"ranges": [[...]]}, the scans
    {"measure": 0.5}                                 runs for so long; {"rate": robot-steps/s}
    {"close": true}

A rate is per second of this process's processor time, on all of its threads.
"""

import importlib
import json
import sys
import time
from typing import Any, Dict, TextIO

CLOCK_PERIOD = 0.001
"""Interval between clock readings [s]; one reading can take a fifth of a step's time."""
WARM_UP = 0.2
"""Duration of the warm-up, as a share of the measurement's."""


class Worker:
    """Answers requests.

    Args:
        rooms: the module that opens rooms.
    """

    def __init__(self, rooms: Any) -> None:
        self._rooms = rooms
        self._room: Any = None

    def answer(self, request: Dict[str, Any]) -> Dict[str, Any]:
        """Does what a request asks for."""
        if "open" in request:
            kind, variant = request["open"], request["variant"]
            robots, seed = request["robots"], request["seed"]
            self._room = self._rooms.open_room(kind, variant, robots, seed)
            return {"ranges": [[float(value) for value in scan] for scan in self._room.scans()]}
        if "measure" in request:
            self._run(WARM_UP * request["measure"])
            return {"rate": self._run(request["measure"])}
        self._room.close()
        self._room = None
        return {}

    def _run(self, seconds: float) -> float:
        """Steps the room for a time; returns robot-steps per second."""
        steps, block, begin = 0, 1, time.process_time()
        while True:
            self._room.run(block)
            steps += block
            spent = time.process_time() - begin
            if spent >= seconds:
                return steps * float(self._room.robots) / spent
            block = max(1, int(CLOCK_PERIOD * steps / spent))


def serve(rooms: Any, requests: TextIO, answers: TextIO) -> None:
    """Answers requests until there are no more."""
    worker = Worker(rooms)
    for line in requests:
        print(json.dumps(worker.answer(json.loads(line))), file=answers, flush=True)


if __name__ == "__main__":
    to_parent = sys.stdout
    sys.stdout = sys.stderr  # keeps prints of simulators out of the answers
    serve(importlib.import_module(sys.argv[1]), sys.stdin, to_parent)
