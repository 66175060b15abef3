"""The program of a worker process: runs scenarios that it is sent, until its parent ends.

`worker_process` starts it. Messages are pickled, over a socket. Input: first the
`SweepSettings`, then jobs; output: `READY` first, then an answer to each job. The worker ends when
the socket is closed, also in the middle of a scenario: no process is left behind by a parent that
was killed.
"""

import logging
import os
import queue
import threading
from multiprocessing.connection import Connection
from typing import Any

from flatland_server.sweep.jobs import JobRunner

READY = "ready"


def main(descriptor: int) -> None:
    """Runs what is sent.

    Args:
        descriptor: of the socket.
    """
    os.dup2(2, 1)  # what controllers print does not mix with the results on standard output
    logging.basicConfig(format="%(message)s", level=logging.WARNING)
    connection = Connection(descriptor)
    received: queue.SimpleQueue[Any] = queue.SimpleQueue()

    def receive() -> None:
        try:
            while True:
                received.put(connection.recv())
        except (EOFError, OSError):
            os._exit(0)

    threading.Thread(target=receive, daemon=True).start()
    runner = JobRunner(received.get())
    connection.send(READY)
    while True:
        answer = runner.run(received.get())
        try:
            connection.send(answer)
        except OSError:
            os._exit(0)  # the parent has ended
