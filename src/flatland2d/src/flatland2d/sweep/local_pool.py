"""Runs scenarios in worker processes on this machine.

A worker is

    starting    until its first message has come
    idle        ready, without a scenario
    busy        running a scenario, until its answer has come
    gone        it has died, or was stopped since its scenario took too long; another one is started

Parent and worker send each other pickled messages over a socket. The worker gets the
`SweepSettings`, then pairs of a function and a scenario. It answers with its process id, the number
of the scenario (0 when it is ready) and what the function has returned. A process that a controller
has forked ends when it returns from the controller; an answer with another process id or number is
refused.

A worker leads a process group, in which the processes that controllers start are, too. The parent
kills the whole group when the worker ends; if the parent itself is killed, the worker's guard does.
"""

import logging
import os
import pickle
import signal
import subprocess
import sys
import time
from collections import Counter, deque
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing import Pipe
from multiprocessing.connection import Connection, wait
from typing import Any, Callable, Deque, Generic, Iterable, Iterator, List, Optional, TypeVar

from flatland2d.sweep.runner import ScenarioRunner
from flatland2d.sweep.settings import Scenario, SweepSettings
from flatland_server.exceptions import FlatlandError

_MAX_FAILED_STARTS = 5
"""The number of workers in a row that may die before they are ready."""

_PROGRAM = """
import sys
if sys.path[0] == "":  # imports nothing from the working directory
    del sys.path[0]
from flatland2d.sweep.local_pool import work
work(int(sys.argv[1]))
"""

_GUARD = 'read -r _; kill -s KILL -- "-$0"'
"""The program of a guard: waits until the parent has ended, and kills a process group.

A process of its own: a worker may be stopped, or hang in C code that lets no other thread run.
"""

_DEATH_LIMIT = 1.0
"""Real time in which a worker that has closed its connection must have ended [s]."""

_MAX_ANSWER = 1 << 28
"""Largest message of a worker [bytes]: a controller may have written to the socket."""

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
        settings: the sweep's settings.
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
            scenarios: the scenarios, each once.

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
        except FlatlandError as error:
            self.report(str(error))
            return None
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
        self._guard = subprocess.Popen(
            ["/bin/sh", "-c", _GUARD, str(self._process.pid)],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
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
        """Its answer, after which it is idle.

        Raises:
            EOFError: it has died, or the message cannot be read.
            FlatlandError: it is the answer of another process, or to another scenario.
        """
        try:
            message = self.connection.recv_bytes(_MAX_ANSWER)
            process, number, answer = pickle.loads(message)
        except Exception:  # a controller may write anything
            raise EOFError from None
        expected = self.scenario.number if self.scenario else 0
        if (process, number) != (self._process.pid, expected):
            raise FlatlandError(
                f"expected an answer of process {self._process.pid} to scenario {expected}, found "
                f"one of process {process} to scenario {number}: it is refused"
            )
        self.is_ready, self.scenario = True, None
        return answer

    def death(self) -> str:
        """Waits for its end; returns the cause, such as "was killed by SIGKILL"."""
        try:
            code = self._process.wait(_DEATH_LIMIT)
        except subprocess.TimeoutExpired:
            return "has closed its connection or written to it"
        if code < 0:
            names = {each.value: each.name for each in signal.Signals}
            return f"was killed by {names.get(-code, f'signal {-code}')}"
        return f"has ended with exit code {code}"

    def kill(self) -> None:
        """Ends it at once, with its process group."""
        with suppress(OSError):  # there is no process in the group any more
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()
        self._guard.kill()
        self._guard.communicate()
        self.connection.close()

    def _send(self, message: object) -> None:
        with suppress(OSError):  # it has died, as its connection says
            self.connection.send(message)


def work(descriptor: int) -> None:
    """The program of a worker: runs the scenarios that its parent sends."""
    os.dup2(2, 1)  # what controllers print does not mix with the results on standard output
    logging.basicConfig(format="%(message)s", level=logging.WARNING)
    os.set_inheritable(descriptor, False)  # by programs that controllers start
    connection: Connection[Any, Any] = Connection(descriptor)
    os.register_at_fork(after_in_child=connection.close)
    process, inode = os.getpid(), os.fstat(descriptor).st_ino

    def answer(number: int, content: Any) -> None:
        with _until_the_parent_ends():
            if os.fstat(descriptor).st_ino != inode:
                raise OSError  # a controller has closed it, and opened another file
            connection.send((process, number, content))

    def receive() -> Any:
        with _until_the_parent_ends():
            return connection.recv()

    runner = ScenarioRunner(receive())
    answer(0, None)
    while True:
        function, scenario = receive()
        answer(scenario.number, function(runner, scenario))


@contextmanager
def _until_the_parent_ends() -> Iterator[None]:
    """Ends this worker if the connection to its parent is closed."""
    try:
        yield
    except (EOFError, OSError):
        os._exit(0)
