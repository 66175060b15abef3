"""Scaling of sweeps and of training-data collection with the number of workers (docs/scaling.md).

    usage: scaling.py [--workers 1 2] [--ray] [--scenarios 200] [--steps 200000]

Prints a table. Needs Flatland and its extra gym; with --ray, also the extra ray. Outside of a
workspace, flatland_benchmark is found by PYTHONPATH=src/flatland_benchmark/src. Runs the
room with discs and its trained policy. CPU seconds are those of the workers' processes without
their start-up; other programs affect them less than real time. They are unknown for workers of Ray.
"""

import argparse
import ctypes
import os
import pickle
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from functools import lru_cache
from itertools import product
from multiprocessing import get_context
from pathlib import Path
from typing import (
    Any,
    Callable,
    Dict,
    Iterable,
    Iterator,
    List,
    NamedTuple,
    Optional,
    Tuple,
    TypeVar,
)

import numpy as np

from flatland2d.sweep.local_pool import LocalPool
from flatland2d.sweep.ray_pool import LOCAL, RayPool
from flatland2d.sweep.runner import ScenarioRunner
from flatland2d.sweep.scenario_file import read_scenario_file
from flatland2d.sweep.settings import SweepSettings, scenarios_of
from flatland_benchmark.tables import head, row
from flatland_gym import SCENARIOS, NavigationVectorEnv, Policy

T = TypeVar("T")

POLICY = (
    Path(__file__).resolve().parents[1] / "src/flatland_gym/src/flatland_gym/policies/discs.npz"
)
SCENARIOS_FILE = """
worlds: [{world}]
controllers: [{{name: trained, policy: {policy}}}]
seeds: {count}
start: random
goal: random
step_size: 0.005
control_period: {period}
"""
ENVIRONMENTS = 64
ROLLOUT = 128


class Figures(NamedTuple):
    """The figures of one measurement."""

    seconds: float  # of real time
    cpu: Optional[float]  # s, of all workers together
    steps: int  # control steps, or steps of environments
    sent: int  # bytes to workers
    received: int  # bytes from workers


def timed(
    pool: Any, warm_up: Callable[[], Any], work: Callable[[], T], on_ray: bool
) -> Tuple[T, float, Optional[float]]:
    """The result of the work, its real time, and the processor time of its processes [s]."""
    try:
        warm_up()
        pids = children()
        begin, begin_cpu = time.perf_counter(), 0.0 if on_ray else cpu_of(pids)
        result = work()
        seconds = time.perf_counter() - begin
        return result, seconds, None if on_ray else cpu_of(pids) - begin_cpu
    finally:
        pool.close()


# Sweeps


def sweep_settings(folder: Path, count: int) -> SweepSettings:
    """A sweep of the room with discs, driven by the policy trained in it."""
    period = Policy.load(POLICY).period
    path = folder / "scenarios.yaml"
    path.write_text(
        SCENARIOS_FILE.format(
            world=SCENARIOS["discs"].world, policy=POLICY, count=count, period=period
        )
    )
    return read_scenario_file(path)


def measure_sweep(settings: SweepSettings, workers: int, on_ray: bool) -> Figures:
    """Runs all scenarios on workers that are warmed up."""
    scenarios = scenarios_of(settings)
    pool: Any = RayPool(settings, LOCAL, workers) if on_ray else LocalPool(settings, workers)
    done, seconds, cpu = timed(
        pool,
        lambda: list(pool.map(ScenarioRunner.run, scenarios[: 4 * workers])),
        lambda: list(pool.map(ScenarioRunner.run, scenarios)),
        on_ray,
    )
    simulated = sum(each.answer.row["time"] for each in done)
    return Figures(
        seconds,
        cpu,
        round(simulated / settings.control_period),
        sum(len(pickle.dumps((ScenarioRunner.run, each))) for each in scenarios),
        sum(len(pickle.dumps(each.answer)) for each in done),
    )


# Training: workers collect rollouts of a policy for a learner


class Collector:
    """Environments of a worker, and their last observations."""

    def __init__(self, seed: int) -> None:
        self._env = NavigationVectorEnv(ENVIRONMENTS, world="discs", autoreset_mode="SameStep")
        self._observations = self._env.reset(seed=seed)[0]

    def collect(self, policy: Policy) -> Dict[str, Any]:
        """A rollout of a policy: the arrays that a learner needs."""
        kept: Dict[str, List[Any]] = {"observations": [], "actions": [], "rewards": [], "ends": []}
        for _ in range(ROLLOUT):
            actions = policy.act(self._observations)
            observations, rewards, terminated, truncated, _ = self._env.step(actions)
            ends = terminated | truncated
            step = (self._observations, actions, rewards.astype(np.float32), ends)
            for values, value in zip(kept.values(), step):
                values.append(value)
            self._observations = observations
        return {name: np.array(values) for name, values in kept.items()}


_collector_of = lru_cache(maxsize=1)(Collector)


def collect(policy: Policy, seed: int) -> Dict[str, Any]:
    """A rollout by this process's collector."""
    return _collector_of(seed).collect(policy)


def measure_rollouts(steps: int, workers: int, on_ray: bool) -> Figures:
    """Collects rollouts in rounds: all workers get the policy, and each returns a rollout."""
    policy = Policy.load(POLICY)
    rounds = max(2, round(steps / workers / ENVIRONMENTS / ROLLOUT))
    pool: Any = RayExecutor(workers) if on_ray else LocalExecutor(workers)

    def run(rounds: int) -> Tuple[int, int]:
        """Counts the steps, and the bytes that come back."""
        count = received = 0
        for _ in range(rounds):
            for rollout in pool.map(policy):
                received += sum(array.nbytes for array in rollout.values())
                count += rollout["rewards"].size
        return count, received

    (count, received), seconds, cpu = timed(pool, lambda: run(2), lambda: run(rounds), on_ray)
    return Figures(seconds, cpu, count, rounds * workers * len(pickle.dumps(policy)), received)


class LocalExecutor:
    """Processes of this machine; each has environments of its own."""

    def __init__(self, workers: int) -> None:
        context = get_context("fork")
        self._pools = [ProcessPoolExecutor(1, mp_context=context) for _ in range(workers)]

    def map(self, policy: Policy) -> Iterator[Dict[str, Any]]:
        """A rollout of each worker."""
        futures = [pool.submit(collect, policy, seed) for seed, pool in enumerate(self._pools)]
        return (future.result() for future in futures)

    def close(self) -> None:
        """Ends the processes."""
        for pool in self._pools:
            pool.shutdown()


class RayExecutor:
    """Actors of Ray; each has environments of its own."""

    def __init__(self, workers: int) -> None:
        import ray

        self._ray = ray
        ray.init(address=LOCAL, num_cpus=workers, include_dashboard=False, logging_level="error")
        actor = ray.remote(num_cpus=1)(Collector)
        self._actors = [actor.remote(seed) for seed in range(workers)]

    def map(self, policy: Policy) -> Iterator[Dict[str, Any]]:
        """A rollout of each worker."""
        shared = self._ray.put(policy)
        return iter(self._ray.get([actor.collect.remote(shared) for actor in self._actors]))

    def close(self) -> None:
        """Ends Ray."""
        self._ray.shutdown()


# Processes


def children() -> List[int]:
    """The processes that this one has started."""
    return [int(pid) for pid in Path(f"/proc/self/task/{os.getpid()}/children").read_text().split()]


def cpu_of(pids: Iterable[int]) -> float:
    """Processor time of processes [s]."""
    total = 0.0
    for pid in pids:
        clock = ctypes.c_int()
        ctypes.CDLL(None).clock_getcpuclockid(pid, ctypes.byref(clock))
        total += time.clock_gettime(clock.value)
    return total


def row_of(name: str, workers: int, found: Figures, first: Figures) -> str:
    """A line of the table."""
    million = 1e6 / found.steps
    pace, alone = found.steps / found.seconds, first.steps / first.seconds
    cpu = "" if found.cpu is None else found.cpu * million
    sizes = (count * million / 1e6 for count in (found.sent, found.received))
    return row(name, workers, pace, pace / alone, cpu, *sizes)


def main() -> None:
    """Measures, and prints the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--workers", type=int, nargs="+", default=[1, 2], help="numbers of them")
    parser.add_argument("--ray", action="store_true", help="measure Ray, too")
    parser.add_argument("--scenarios", type=int, default=200, help="of the sweep")
    parser.add_argument("--steps", type=int, default=200_000, help="of environments")
    options = parser.parse_args()
    sizes = ("sent [MB per million]", "received [MB per million]")
    columns = ("", "workers", "steps/s", "speed-up", "CPU per million steps [s]", *sizes)
    print(head(*columns), flush=True)
    with tempfile.TemporaryDirectory() as folder:
        settings = sweep_settings(Path(folder), options.scenarios)
        first: Dict[str, Figures] = {}
        for on_ray in (False, True)[: 1 + options.ray]:
            for kind, workers in product(("sweep", "rollouts"), options.workers):
                if kind == "sweep":
                    found = measure_sweep(settings, workers, on_ray)
                else:
                    found = measure_rollouts(options.steps, workers, on_ray)
                alone = first.setdefault(kind, found)
                name = f"{kind}, {'Ray' if on_ray else 'processes'}"
                print(row_of(name, workers, found, alone), flush=True)


if __name__ == "__main__":
    main()
