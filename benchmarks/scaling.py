"""Scaling of sweeps and of training-data collection with the number of workers (docs/scaling.md).

    usage: scaling.py [--workers 1 2] [--ray] [--scenarios 200] [--steps 200000]

Prints a Markdown table. Needs Flatland and its extra gym; with --ray, also the extra ray. Runs the
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
from typing import Any, Dict, Iterable, Iterator, List, NamedTuple, Optional

import numpy as np

from flatland2d.sweep.local_pool import LocalPool
from flatland2d.sweep.ray_pool import LOCAL, RayPool
from flatland2d.sweep.runner import ScenarioRunner
from flatland2d.sweep.scenario_file import read_scenario_file
from flatland2d.sweep.settings import SweepSettings, scenarios_of
from flatland_gym import SCENARIOS, NavigationVectorEnv, Policy

POLICY = (
    Path(__file__).resolve().parents[1] / "src/flatland_gym/src/flatland_gym/policies/discs.npz"
)
SCENARIOS_FILE = """
worlds: [{world}]
controllers: [{{name: trained, policy: {policy}}}]
seeds: {count}
start: random
goal: random
step_size: {step_size}
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


# Sweeps


def sweep_settings(folder: Path, count: int) -> SweepSettings:
    """A sweep of the room with discs, driven by the policy trained in it."""
    period = Policy.load(POLICY).period
    path = folder / "scenarios.yaml"
    path.write_text(
        SCENARIOS_FILE.format(
            world=SCENARIOS["discs"].world,
            policy=POLICY,
            count=count,
            step_size=0.005,
            period=period,
        )
    )
    return read_scenario_file(path)


def measure_sweep(settings: SweepSettings, workers: int, on_ray: bool) -> Figures:
    """Runs all scenarios on workers that are warmed up."""
    scenarios = scenarios_of(settings)
    pool: Any = RayPool(settings, LOCAL, workers) if on_ray else LocalPool(settings, workers)
    try:
        for _ in pool.map(ScenarioRunner.run, scenarios[: 4 * workers]):
            pass
        pids = [] if on_ray else children()
        begin, begin_cpu = time.perf_counter(), cpu_of(pids)
        done = list(pool.map(ScenarioRunner.run, scenarios))
        seconds, cpu = time.perf_counter() - begin, cpu_of(pids) - begin_cpu
    finally:
        pool.close()
    simulated = sum(each.answer.row["time"] for each in done)
    return Figures(
        seconds,
        None if on_ray else cpu,
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


@lru_cache(maxsize=1)
def collector(seed: int) -> Collector:
    """The collector of this process."""
    return Collector(seed)


def collect(policy: Policy, seed: int) -> Dict[str, Any]:
    """A rollout by this process's collector."""
    return collector(seed).collect(policy)


def measure_rollouts(steps: int, workers: int, on_ray: bool) -> Figures:
    """Collects rollouts in rounds: all workers get the policy, and each returns a rollout."""
    policy = Policy.load(POLICY)
    rounds = max(2, round(steps / workers / ENVIRONMENTS / ROLLOUT))
    pool: Any = RayExecutor(workers) if on_ray else LocalExecutor(workers)
    try:
        for _ in range(2):
            list(pool.map(policy))
        pids = [] if on_ray else children()
        begin, begin_cpu = time.perf_counter(), cpu_of(pids)
        received = count = 0
        for _ in range(rounds):
            for rollout in pool.map(policy):
                received += sum(array.nbytes for array in rollout.values())
                count += rollout["rewards"].size
        seconds, cpu = time.perf_counter() - begin, cpu_of(pids) - begin_cpu
    finally:
        pool.close()
    sent = rounds * workers * len(pickle.dumps(policy))
    return Figures(seconds, None if on_ray else cpu, count, sent, received)


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
    cpu = f"{found.cpu * million:.0f} s" if found.cpu is not None else ""
    sent, received = (f"{count * million / 1e6:.1f} MB" for count in (found.sent, found.received))
    cells = [name, workers, f"{pace:,.0f}", f"{pace / alone:.2f}", cpu, sent, received]
    return f"| {' | '.join(map(str, cells))} |"


def main() -> None:
    """Measures, and prints the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--workers", type=int, nargs="+", default=[1, 2], help="numbers of them")
    parser.add_argument("--ray", action="store_true", help="measure Ray, too")
    parser.add_argument("--scenarios", type=int, default=200, help="of the sweep")
    parser.add_argument("--steps", type=int, default=200_000, help="of environments")
    options = parser.parse_args()
    heads = ("", "workers", "steps/s", "speed-up", "CPU per million steps", "sent", "received")
    print(f"| {' | '.join(heads)} |\n|{' --- |' * len(heads)}", flush=True)
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
