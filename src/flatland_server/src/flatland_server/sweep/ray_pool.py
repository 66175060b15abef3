"""Workers on a Ray cluster. Ray hands out the jobs; each is done by a worker process beside it.

A scenario that crashes or hangs therefore costs one of our processes, and is treated as on one
machine: the same attempts, limits and reasons. What Ray repeats by itself is what is lost with a
machine.
"""

import os
from dataclasses import replace
from pathlib import Path
from typing import Any, Callable, Dict, Iterable, Iterator, List, Optional, Tuple

from flatland_server.exceptions import FlatlandError
from flatland_server.sweep.extras import how_to_install
from flatland_server.sweep.jobs import Job
from flatland_server.sweep.local_pool import Done, LocalPool
from flatland_server.sweep.runner import Result
from flatland_server.sweep.settings import SweepSettings

LOCAL = "local"
"""In place of an address: a Ray of its own on this machine."""

_RETRIES = 3  # of Ray, for machines that are lost

_pools: Dict[str, LocalPool] = {}  # of this process, by the scenario file


class RayPool:
    """Does jobs on a Ray cluster.

    Args:
        settings: of the sweep.
        address: of the cluster, such as "auto" or "ray://head:10001"; "local" starts one.
        size: how many jobs are done at a time; None: as many as the cluster has CPUs.
        report: called with a sentence for each worker that has died or was stopped.
        excluded: a folder of results that is not sent to the workers.

    Raises:
        FlatlandError: Ray is not installed, or the cluster cannot be reached.
    """

    def __init__(
        self,
        settings: SweepSettings,
        address: str,
        size: Optional[int],
        report: Callable[[str], None] = lambda _: None,
        excluded: Optional[Path] = None,
    ) -> None:
        os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")  # tells its makers nothing
        try:
            import ray
        except ImportError as error:
            raise FlatlandError(
                f"--ray needs Ray: {how_to_install('ray', 'ray')} ({error})"
            ) from None
        self._ray = ray
        self._settings = settings
        self._report = report
        options: Dict[str, Any] = {"address": address}
        if address == LOCAL:
            options = {"address": LOCAL, "num_cpus": size, "include_dashboard": False}
        else:
            # The scenario file's folder, for machines that do not have it.
            environment: Dict[str, Any] = {"working_dir": str(settings.folder)}
            if excluded is not None:
                environment["excludes"] = [excluded.name]
            options["runtime_env"] = environment
        try:
            ray.init(log_to_driver=True, logging_level="warning", **options)
        except Exception as error:  # Ray has no class of its own for these
            raise FlatlandError(f"the Ray cluster at {address} cannot be used: {error}") from error
        self._size = size or max(1, int(ray.cluster_resources().get("CPU", 1)))
        self._run = ray.remote(num_cpus=1, max_retries=_RETRIES)(_run_remotely)
        self._shared = ray.put(settings)

    def map(self, jobs: Iterable[Job]) -> Iterator[Done]:
        """Does jobs; yields each when it is done, in any order."""
        waiting = iter(jobs)
        running: Dict[Any, Job] = {}
        while True:
            for job in waiting:
                running[self._run.remote(self._shared, job)] = job
                if len(running) >= self._size:
                    break
            if not running:
                return
            ready, _ = self._ray.wait(list(running), num_returns=1)
            for reference in ready:
                yield self._done(reference, running.pop(reference))

    def close(self) -> None:
        """Leaves the cluster; one that was started for this sweep ends."""
        self._ray.shutdown()

    def _done(self, reference: Any, job: Job) -> Done:
        try:
            done, messages = self._ray.get(reference)
        except self._ray.exceptions.RayTaskError as error:
            cause = error.cause if isinstance(error.cause, FlatlandError) else error
            raise FlatlandError(f"a worker of Ray: {cause}") from error
        except self._ray.exceptions.RayError as error:
            reason = f"Ray has lost its worker: {type(error).__name__}"
            self._report(f"{job.scenario}: {reason}")
            return Done(job, b"" if job.is_picture else Result({}, {}, reason), 0.0, 1 + _RETRIES)
        for message in messages:
            self._report(message)
        found: Done = done
        return found


def _run_remotely(settings: SweepSettings, job: Job) -> Tuple[Done, List[str]]:
    """Does a job in a worker process that stays for the next one. Called in a process of Ray."""
    if not settings.folder.is_dir():  # another machine: Ray has put the folder here
        settings = replace(settings, file=Path.cwd() / settings.file.name)
    key = str(settings.file)
    messages: List[str] = []
    if key not in _pools:
        _pools[key] = LocalPool(settings, 1)
    pool = _pools[key]
    pool.report_to(messages.append)
    [done] = pool.map([job])
    return done, messages
