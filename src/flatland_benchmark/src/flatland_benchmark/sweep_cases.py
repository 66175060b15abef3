"""Sweeps and rollouts by several workers."""

import json
import pickle
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from functools import lru_cache
from multiprocessing import get_context
from pathlib import Path
from statistics import mean
from typing import Any, Callable, List, Tuple, TypeVar

import numpy as np

from flatland2d.sweep.local_pool import LocalPool
from flatland2d.sweep.runner import ScenarioRunner
from flatland2d.sweep.scenario_file import read_scenario_file
from flatland2d.sweep.settings import scenarios_of
from flatland_benchmark.case import Figures, case
from flatland_benchmark.process import children, cpu_seconds
from flatland_gym import Policy

T = TypeVar("T")

_WORKERS = (1, 2, 4)
_SCENARIOS = 60
_STEPS = 150_000
"""Of rollouts."""


def _timed(work: Callable[[], T]) -> Tuple[T, float, float]:
    """The result of the work, its real time and the processor time of our child processes [s]."""
    workers = children()
    begin, cpu = time.perf_counter(), sum(map(cpu_seconds, workers))
    result = work()
    return result, time.perf_counter() - begin, sum(map(cpu_seconds, workers)) - cpu


@case("sweep_{workers}", "60 scenarios by a policy, workers: {workers}", workers=_WORKERS)
def run_sweep(worlds: Path, workers: int) -> Figures:
    """The room with discs, and the policy that was trained in it."""
    content = {
        "worlds": ["package://flatland_gym/worlds/discs.yaml"],
        "controllers": [{"name": "it", "policy": "package://flatland_gym/policies/discs.npz"}],
        "seeds": _SCENARIOS,
        "control_period": Policy.load("discs").period,
        "start": "random",
        "goal": "random",
    }
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "scenarios.yaml")
        file.write_text(json.dumps(content))
        settings = read_scenario_file(file)
        scenarios = scenarios_of(settings)
        pool = LocalPool(settings, workers)
        try:
            list(pool.map(ScenarioRunner.run, scenarios[: 4 * workers]))  # starts the workers
            done, seconds, cpu = _timed(lambda: list(pool.map(ScenarioRunner.run, scenarios)))
        finally:
            pool.close()
    answers = [each.answer for each in done if each.answer is not None]
    steps = sum(answer.row["time"] for answer in answers) / settings.control_period
    return {
        "steps/s": steps / seconds,
        "CPU per million steps [s]": cpu / steps * 1e6,
        "scenario [kB]": mean(len(pickle.dumps((ScenarioRunner.run, s))) for s in scenarios) / 1e3,
        "its answer [kB]": mean(len(pickle.dumps(answer)) for answer in answers) / 1e3,
    }


class _Collector:
    """Environments of a worker, and their last observations."""

    ENVIRONMENTS = 64
    STEPS = 128
    """Of each environment in a rollout."""

    def __init__(self, seed: int) -> None:
        from flatland_gym import NavigationVectorEnv

        self._env = NavigationVectorEnv(self.ENVIRONMENTS, world="discs", autoreset_mode="SameStep")
        self._observations = self._env.reset(seed=seed)[0]

    def collect(self, policy: Policy) -> List[Any]:
        """A rollout of a policy: the arrays that a learner needs."""
        steps = []
        for _ in range(self.STEPS):
            actions = policy.act(self._observations)
            observations, rewards, terminated, truncated, _ = self._env.step(actions)
            ends = terminated | truncated
            steps.append((self._observations, actions, rewards.astype(np.float32), ends))
            self._observations = observations
        return [np.array(values) for values in zip(*steps)]


_collector_of = lru_cache(maxsize=1)(_Collector)


def _collect(policy: Policy, seed: int) -> List[Any]:
    """A rollout by this process's collector."""
    return _collector_of(seed).collect(policy)


@case("rollouts_{workers}", "rollouts of a policy by workers: {workers}", workers=_WORKERS)
def collect_rollouts(worlds: Path, workers: int) -> Figures:
    """Rounds, as of a learner: all workers get the policy, and each returns a rollout."""
    policy = Policy.load("discs")
    context = get_context("fork")
    pools = [ProcessPoolExecutor(1, mp_context=context) for _ in range(workers)]

    def run(rounds: int) -> int:
        """The bytes that come back."""
        received = 0
        for _ in range(rounds):
            futures = [pool.submit(_collect, policy, i) for i, pool in enumerate(pools)]
            received += sum(array.nbytes for each in futures for array in each.result())
        return received

    each_round = workers * _Collector.ENVIRONMENTS * _Collector.STEPS
    rounds = max(1, round(_STEPS / each_round))
    run(2)
    received, seconds, cpu = _timed(lambda: run(rounds))
    for pool in pools:
        pool.shutdown()
    steps = rounds * each_round
    return {
        "steps/s": steps / seconds,
        "CPU per million steps [s]": cpu / steps * 1e6,
        "policy [kB]": len(pickle.dumps(policy)) / 1e3,
        "back per step [bytes]": received / steps,
    }
