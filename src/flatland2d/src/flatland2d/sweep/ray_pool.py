"""Workers on a Ray cluster. Ray hands out scenarios; each is run by a worker process beside it.

A scenario that crashes or hangs therefore costs one of our processes, and is treated as on one
machine: the same attempts, limits and reasons. Ray itself repeats scenarios lost with a machine.
"""

import os
from dataclasses import replace
from pathlib import Path
from typing import Any, Callable, Dict, Iterable, Iterator, List, Optional, Tuple, TypeVar

from flatland2d.sweep.local_pool import Done, LocalPool
from flatland2d.sweep.runner import ScenarioRunner
from flatland2d.sweep.settings import Scenario, SweepSettings
from flatland_server.exceptions import FlatlandError, pip_install

LOCAL = "local"
"""Instead of an address: starts a cluster on this machine alone."""

_RETRIES = 3  # of Ray, for machines that are lost

_pools: Dict[str, LocalPool] = {}  # of this process, by the scenario file

T = TypeVar("T")


class RayPool:
    """Runs scenarios on a Ray cluster.

    Args:
        settings: the sweep's settings.
        address: of the cluster, such as "auto" or "ray://head:10001"; "local" starts one.
        size: how many scenarios run at a time; None: as many as the cluster has CPUs.
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
        os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")  # no usage statistics
        try:
            import ray
        except ImportError as error:
            raise FlatlandError(
                f"--ray needs Ray: {pip_install('ray')}, or in a ROS workspace as "
                f"docs/sweeps.md says under Parquet and Ray ({error})"
            ) from None
        self._ray = ray
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

    def map(
        self, function: Callable[[ScenarioRunner, Scenario], T], scenarios: Iterable[Scenario]
    ) -> Iterator[Done[T]]:
        """Calls a function with each scenario; see `LocalPool.map`."""
        waiting = iter(scenarios)
        running: Dict[Any, Scenario] = {}
        while True:
            for scenario in waiting:
                running[self._run.remote(self._shared, function, scenario)] = scenario
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

    def _done(self, reference: Any, scenario: Scenario) -> Done[Any]:
        try:
            done, messages = self._ray.get(reference)
        except self._ray.exceptions.RayTaskError as error:
            cause = error.cause if isinstance(error.cause, FlatlandError) else error
            raise FlatlandError(f"a worker of Ray: {cause}") from error
        except self._ray.exceptions.RayError as error:
            reason = f"Ray has lost its worker: {type(error).__name__}"
            self._report(f"{scenario}: {reason}")
            return Done(scenario, None, 0.0, 1 + _RETRIES, reason)
        for message in messages:
            self._report(message)
        found: Done[Any] = done
        return found


def _run_remotely(
    settings: SweepSettings, function: Callable[[ScenarioRunner, Scenario], T], scenario: Scenario
) -> Tuple[Done[T], List[str]]:
    """Runs a scenario in a worker that stays for the next one. Called in a process of Ray."""
    if not settings.folder.is_dir():  # another machine: Ray has put the folder here
        settings = replace(settings, file=Path.cwd() / settings.file.name)
    pool = _pools.setdefault(str(settings.file), LocalPool(settings, 1))
    messages: List[str] = []
    pool.report = messages.append
    [done] = pool.map(function, [scenario])
    return done, messages
