"""A worker process as its parent sees it."""

import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from typing import Any, Optional

from flatland_server.sweep.jobs import Job
from flatland_server.sweep.settings import SweepSettings

_PROGRAM = """
import sys
if sys.path[0] == "":  # imports nothing from the working directory
    del sys.path[0]
from flatland_server.sweep.worker import main
main(int(sys.argv[1]))
"""

_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""How many threads NumPy uses in a worker: 1, unless the user has set it. There are as many workers
as CPUs; and several threads may round a matrix product in another way.
"""


class WorkerProcess:
    """Starts a worker. It is ready for jobs when its first message has come.

    Args:
        settings: of the sweep.

    Attributes:
        connection: its messages; at the end of the file, it has died.
        is_ready: whether its first message has been received.
        job: what it does at present, or None.
    """

    def __init__(self, settings: SweepSettings) -> None:
        self.connection: Connection[Any, Any]
        self.connection, other = Pipe()
        self.is_ready = False
        self.job: Optional[Job] = None
        self._start_time = 0.0
        with other:
            number = str(other.fileno())
            command = [sys.executable or "/usr/bin/python3", "-c", _PROGRAM, number]
            self._process = subprocess.Popen(
                command,
                pass_fds=[other.fileno()],
                stdin=subprocess.DEVNULL,
                env={**dict.fromkeys(_THREADS, "1"), **os.environ},
                start_new_session=True,  # Ctrl-C in a terminal does not reach it
            )
        self._send(settings)

    @property
    def pid(self) -> int:
        """Its process."""
        return self._process.pid

    @property
    def seconds(self) -> float:
        """Real time since its job began [s]."""
        return time.monotonic() - self._start_time

    def begin(self, job: Job) -> None:
        """Gives it a job."""
        self.job = job
        self._start_time = time.monotonic()
        self._send(job)

    def receive(self) -> Any:
        """Its next message.

        Raises:
            EOFError: it has died.
        """
        try:
            return self.connection.recv()
        except OSError:
            raise EOFError from None

    def death(self) -> str:
        """Waits for its end, and says what it was: "was killed by SIGKILL"."""
        code = self._process.wait()
        if code < 0:
            return f"was killed by {signal.Signals(-code).name}"
        return f"has ended with exit code {code}"

    def kill(self) -> None:
        """Ends it at once."""
        self._process.kill()
        self._process.wait()
        self.connection.close()

    def _send(self, message: object) -> None:
        with suppress(OSError):  # it has died, as its connection says
            self.connection.send(message)
