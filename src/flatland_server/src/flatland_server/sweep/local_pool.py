"""Worker processes on this machine: distributes jobs, and replaces workers that die."""

from collections import deque
from dataclasses import dataclass
from multiprocessing.connection import wait
from typing import Callable, Deque, Dict, Iterable, Iterator, List, Optional

from flatland_server.exceptions import FlatlandError
from flatland_server.sweep.jobs import Answer, Job
from flatland_server.sweep.runner import Result
from flatland_server.sweep.settings import SweepSettings
from flatland_server.sweep.worker import READY
from flatland_server.sweep.worker_process import WorkerProcess

_MAX_FAILED_STARTS = 5
"""How many workers in a row may die before they are ready."""


@dataclass(frozen=True)
class Done:
    """A job that is done.

    Attributes:
        job: the job.
        answer: its result; the same wherever it was done.
        seconds: of real time that the last attempt has taken.
        attempts: how often it was begun.
    """

    job: Job
    answer: Answer
    seconds: float
    attempts: int


class LocalPool:
    """Worker processes; each does one job at a time.

    A job is run again if its worker has died. One that takes too long is stopped.

    Args:
        settings: of the sweep.
        size: number of worker processes at most; they are started when they are needed.
        report: called with a sentence for each worker that has died or was stopped.
    """

    def __init__(
        self, settings: SweepSettings, size: int, report: Callable[[str], None] = lambda _: None
    ) -> None:
        self._settings = settings
        self._size = size
        self._report = report
        self._workers: List[WorkerProcess] = []
        self._failed_starts = 0

    def map(self, jobs: Iterable[Job]) -> Iterator[Done]:
        """Does jobs.

        Yields:
            Each job when it is done, in any order.

        Raises:
            FlatlandError: a worker does not start.
        """
        waiting: Deque[Job] = deque(jobs)
        attempts: Dict[int, int] = {}
        self._hand_out(waiting, attempts)
        while waiting or any(worker.job for worker in self._workers):
            found = [self._look_after(each, attempts, waiting) for each in self._wait()]
            self._hand_out(waiting, attempts)  # before the caller processes the answer
            for done in found:
                if done is not None:
                    yield done

    def report_to(self, report: Callable[[str], None]) -> None:
        """Reports to another function from now on."""
        self._report = report

    def close(self) -> None:
        """Ends all workers, at once."""
        while self._workers:
            self._workers.pop().kill()

    def _hand_out(self, waiting: Deque[Job], attempts: Dict[int, int]) -> None:
        """Gives jobs to workers that have none, and starts workers."""
        starting = sum(not worker.is_ready for worker in self._workers)
        while len(self._workers) < self._size and starting < len(waiting):
            self._workers.append(WorkerProcess(self._settings))
            starting += 1
        for worker in self._workers:
            if waiting and worker.is_ready and worker.job is None:
                job = waiting.popleft()
                number = job.scenario.number
                attempts[number] = attempts.get(number, 0) + 1
                worker.begin(job)

    def _wait(self) -> List[WorkerProcess]:
        """Waits; returns workers that have sent a message, have died, or have taken too long."""
        limit = self._settings.real_time_limit
        rest = [max(0.0, limit - worker.seconds) for worker in self._workers if worker.job]
        ready = wait([worker.connection for worker in self._workers], min(rest, default=None))
        return [
            worker
            for worker in self._workers
            if worker.connection in ready or (worker.job and worker.seconds >= limit)
        ]

    def _look_after(
        self, worker: WorkerProcess, attempts: Dict[int, int], waiting: Deque[Job]
    ) -> Optional[Done]:
        """Receives an answer; or replaces a worker that has died or takes too long."""
        job = worker.job
        if not worker.connection.poll():
            assert job is not None
            self._remove(worker)
            limit = self._settings.real_time_limit
            return self._give_up(job, f"it took more than {limit:g} s of real time", attempts)
        try:
            message = worker.receive()
        except EOFError:
            death = worker.death()
            self._remove(worker)
            if job is None:
                self._note_early_death(worker, death)
                return None
            if attempts[job.scenario.number] > self._settings.retries:
                return self._give_up(job, f"its worker {death}, at each attempt", attempts)
            self._report(f"{job.scenario}: its worker {death}; it is run again")
            waiting.appendleft(job)
            return None
        if message == READY:
            worker.is_ready = True
            self._failed_starts = 0
            return None
        assert job is not None
        worker.job = None
        return Done(job, message, worker.seconds, attempts[job.scenario.number])

    def _note_early_death(self, worker: WorkerProcess, death: str) -> None:
        """Raises a FlatlandError if no worker gets ready."""
        self._failed_starts += not worker.is_ready
        if self._failed_starts > _MAX_FAILED_STARTS:
            raise FlatlandError(f"worker processes do not start: each {death}")

    def _give_up(self, job: Job, reason: str, attempts: Dict[int, int]) -> Done:
        """The answer to a job that could not be done."""
        self._report(f"{job.scenario}: {reason}")
        answer: Answer = b"" if job.is_picture else Result({}, {}, reason)
        return Done(job, answer, self._settings.real_time_limit, attempts[job.scenario.number])

    def _remove(self, worker: WorkerProcess) -> None:
        self._workers.remove(worker)
        worker.kill()
