"""Runs scenarios in worker processes on this machine.

A worker is

    starting    until its first message has come
    idle        ready, without a scenario
    busy        running a scenario, until its answer has come
    gone        it has died, or was stopped since its scenario took too long; another one is started

Parent and worker send each other pickled messages over a socket. The worker gets the
`SweepSettings`, then pairs of a function and a scenario; it sends READY, then what the functions
return. It ends when the socket is closed, also in the middle of a scenario, so that no process
outlives a parent that was killed.
"""

import logging
import os
import queue
import signal
import subprocess
import sys
import threading
import time
from collections import Counter, deque
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing import Pipe
from multiprocessing.connection import Connection, wait
from typing import Any, Callable, Deque, Generic, Iterable, Iterator, List, Optional, TypeVar

from flatland2d.sweep.runner import ScenarioRunner
from flatland2d.sweep.settings import Scenario, SweepSettings
from flatland_server.exceptions import FlatlandError

READY = "ready"

_MAX_FAILED_STARTS = 5
"""The number of workers in a row that may die before they are ready."""

_PROGRAM = """
import sys
if sys.path[0] == "":  # imports nothing from the working directory
    del sys.path[0]
from flatland2d.sweep.local_pool import work
work(int(sys.argv[1]))
"""

_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""Variables with NumPy's number of threads: 1 in a worker, unless the user has set them. There are
as many workers as CPUs; and several threads may round a matrix product in another way.
"""

T = TypeVar("T")


@dataclass(frozen=True)
class Done(Generic[T]):
    """A scenario that is done.

    Attributes:
        scenario: the scenario.
        answer: of the function that it was passed to; None if that could not be run to the end.
        seconds: of real time that the last attempt has taken.
        attempts: how often it was begun.
        failure: why it could not be run to the end; empty if it was.
    """

    scenario: Scenario
    answer: Optional[T]
    seconds: float
    attempts: int
    failure: str = ""


class LocalPool:
    """Worker processes; each runs one scenario at a time.

    A scenario is run again if its worker has died. One that takes too long is stopped.

    Args:
        settings: of the sweep.
        size: number of worker processes at most; they are started when they are needed.
        report: called with a sentence for each worker that has died or was stopped.
    """

    def __init__(
        self, settings: SweepSettings, size: int, report: Callable[[str], None] = lambda _: None
    ) -> None:
        self.report = report
        self._settings = settings
        self._size = size
        self._workers: List[_Worker] = []
        self._failed_starts = 0
        self._waiting: Deque[Scenario] = deque()
        self._attempts: Counter[int] = Counter()

    def map(
        self, function: Callable[[ScenarioRunner, Scenario], T], scenarios: Iterable[Scenario]
    ) -> Iterator[Done[T]]:
        """Calls a function with each scenario.

        Args:
            function: of a module, so that it can be pickled.
            scenarios: different ones.

        Yields:
            Each scenario when it is done, in any order.

        Raises:
            FlatlandError: a worker does not start.
        """
        self._waiting = deque(scenarios)
        self._attempts.clear()
        self._hand_out(function)
        while self._waiting or any(worker.scenario for worker in self._workers):
            found = [self._look_after(each) for each in self._wait()]
            self._hand_out(function)  # before the caller processes the answers
            yield from (done for done in found if done is not None)

    def close(self) -> None:
        """Ends all workers, at once."""
        while self._workers:
            self._workers.pop().kill()

    def _hand_out(self, function: Callable[[ScenarioRunner, Scenario], Any]) -> None:
        """Gives scenarios to idle workers, and starts workers."""
        starting = sum(not worker.is_ready for worker in self._workers)
        while len(self._workers) < self._size and starting < len(self._waiting):
            self._workers.append(_Worker(self._settings))
            starting += 1
        for worker in self._workers:
            if self._waiting and worker.is_ready and worker.scenario is None:
                scenario = self._waiting.popleft()
                self._attempts[scenario.number] += 1
                worker.begin(function, scenario)

    def _wait(self) -> List["_Worker"]:
        """Waits; returns workers that have sent a message, have died, or have taken too long."""
        limit = self._settings.real_time_limit
        rest = [max(0.0, limit - worker.seconds) for worker in self._workers if worker.scenario]
        ready = wait([worker.connection for worker in self._workers], min(rest, default=None))
        return [
            worker
            for worker in self._workers
            if worker.connection in ready or (worker.scenario and worker.seconds >= limit)
        ]

    def _look_after(self, worker: "_Worker") -> Optional[Done[Any]]:
        """Receives a message; or removes a worker that has died or takes too long."""
        scenario = worker.scenario
        if scenario is not None and not worker.connection.poll():
            self._remove(worker)
            limit = self._settings.real_time_limit
            return self._give_up(scenario, f"it took more than {limit:g} s of real time")
        try:
            answer = worker.receive()
        except EOFError:
            death = worker.death()
            self._remove(worker)
            return self._note_death(worker, death)
        if scenario is None:
            self._failed_starts = 0
            return None
        return Done(scenario, answer, worker.seconds, self._attempts[scenario.number])

    def _note_death(self, worker: "_Worker", death: str) -> Optional[Done[Any]]:
        """Queues the scenario of a dead worker again, or gives it up.

        Raises:
            FlatlandError: too many workers have died before they were ready.
        """
        scenario = worker.scenario
        if scenario is None:
            self._failed_starts += not worker.is_ready
            if self._failed_starts > _MAX_FAILED_STARTS:
                raise FlatlandError(f"worker processes do not start: each {death}")
            return None
        if self._attempts[scenario.number] > self._settings.retries:
            return self._give_up(scenario, f"its worker {death}, at each attempt")
        self.report(f"{scenario}: its worker {death}; it is run again")
        self._waiting.appendleft(scenario)
        return None

    def _give_up(self, scenario: Scenario, reason: str) -> Done[Any]:
        self.report(f"{scenario}: {reason}")
        limit = self._settings.real_time_limit
        return Done(scenario, None, limit, self._attempts[scenario.number], reason)

    def _remove(self, worker: "_Worker") -> None:
        self._workers.remove(worker)
        worker.kill()


class _Worker:
    """A worker as its parent sees it.

    Args:
        settings: of the sweep.

    Attributes:
        connection: its messages; at the end of the file, it has died.
        is_ready: whether its first message has been received.
        scenario: that it runs, or None.
    """

    def __init__(self, settings: SweepSettings) -> None:
        self.connection: Connection[Any, Any]
        self.connection, other = Pipe()
        self.is_ready = False
        self.scenario: Optional[Scenario] = None
        self._start_time = 0.0
        with other:
            number = str(other.fileno())
            self._process = subprocess.Popen(
                [sys.executable or "/usr/bin/python3", "-c", _PROGRAM, number],
                pass_fds=[other.fileno()],
                stdin=subprocess.DEVNULL,
                env={**dict.fromkeys(_THREADS, "1"), **os.environ},
                start_new_session=True,  # Ctrl-C in a terminal does not reach it
            )
        self._send(settings)

    @property
    def seconds(self) -> float:
        """Real time since its scenario began [s]."""
        return time.monotonic() - self._start_time

    def begin(
        self, function: Callable[[ScenarioRunner, Scenario], Any], scenario: Scenario
    ) -> None:
        """Gives it a scenario."""
        self.scenario = scenario
        self._start_time = time.monotonic()
        self._send((function, scenario))

    def receive(self) -> Any:
        """Its next message, after which it is idle.

        Raises:
            EOFError: it has died.
        """
        try:
            message = self.connection.recv()
        except OSError:
            raise EOFError from None
        self.is_ready, self.scenario = True, None
        return message

    def death(self) -> str:
        """Waits for its end; returns the cause, such as "was killed by SIGKILL"."""
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


def work(descriptor: int) -> None:
    """The program of a worker: runs the scenarios that its parent sends.

    Args:
        descriptor: of the socket.
    """
    os.dup2(2, 1)  # what controllers print does not mix with the results on standard output
    logging.basicConfig(format="%(message)s", level=logging.WARNING)
    connection: Connection[Any, Any] = Connection(descriptor)
    received: queue.SimpleQueue[Any] = queue.SimpleQueue()

    def receive() -> None:
        try:
            while True:
                received.put(connection.recv())
        except (EOFError, OSError):
            os._exit(0)

    threading.Thread(target=receive, daemon=True).start()
    runner = ScenarioRunner(received.get())
    connection.send(READY)
    while True:
        function, scenario = received.get()
        answer = function(runner, scenario)
        try:
            connection.send(answer)
        except OSError:
            os._exit(0)  # the parent has ended
