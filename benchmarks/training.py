"""Steps of `make_vec` in the office as a user makes them: creation, then steps with resets.

    usage: training.py [--environments 1024] [--steps 1000000] [--runs 3]
    usage: training.py --robots 8 --world discs --beams 64     # steps of the robots of teams
    usage: training.py --world empty_room --beams 64 --maps 300     # a map for each episode

Needs Flatland and its extra gym; outside of a workspace, flatland_benchmark is found by
PYTHONPATH=src/flatland_benchmark/src. Each run is a process. CPU seconds are less affected by other
programs.
"""

import argparse
import json
import subprocess
import sys
import time
from statistics import median
from typing import Any, Dict, List

import gymnasium
import numpy as np

from flatland_benchmark.tables import head, row
from flatland_gym import Rooms  # registers the environments, too
from flatland_gym.multi_robot_vector_env import MultiRobotVectorEnv

_HELD = 10
"""Steps with the same random actions."""


def measure(options: argparse.Namespace) -> Dict[str, float]:
    """The seconds that creation and steps take, and the processor time of both."""
    begin, begin_cpu = time.perf_counter(), time.process_time()
    arguments: Dict[str, Any] = {
        "num_envs": options.environments,
        "world": options.world,
        "beams": options.beams,
    }
    if options.maps:
        arguments.update(maps=Rooms(), num_maps=options.maps)
    if options.robots == 1:
        env = gymnasium.make_vec("flatland/Navigation-v0", **arguments)
    else:
        env = MultiRobotVectorEnv(robots=options.robots, **arguments)
    env.reset(seed=0)
    created, created_cpu = time.perf_counter(), time.process_time()
    rng, space = np.random.default_rng(0), env.action_space
    assert isinstance(space, gymnasium.spaces.Box)
    actions = space.sample()
    made = step = 0
    while made < options.steps:
        if step % _HELD == 0:
            actions = rng.uniform(space.low, space.high)
        infos = env.step(actions)[-1]
        made += int(infos["present"].sum()) if options.robots > 1 else options.environments
        step += 1
    end, end_cpu = time.perf_counter(), time.process_time()
    env.close()
    return {
        "creation [s]": created - begin,
        "env steps/s with creation": made / (end - begin),
        "env steps/s": made / (end - created),
        "CPU per env step with creation [us]": (end_cpu - begin_cpu) / made * 1e6,
        "CPU per env step [us]": (end_cpu - created_cpu) / made * 1e6,
    }


def main() -> None:
    """Prints the medians."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--environments", type=int, default=1024)
    parser.add_argument("--robots", type=int, default=1, help="in each environment")
    parser.add_argument("--world", default="office")
    parser.add_argument("--beams", type=int, default=360)
    parser.add_argument("--maps", type=int, help="of Rooms, which episodes draw from")
    parser.add_argument("--steps", type=int, default=1_000_000)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--one", action="store_true", help="run once, in this process")
    options = parser.parse_args()
    if options.one:
        print(json.dumps(measure(options)))
        return
    runs: List[Dict[str, float]] = []
    for _ in range(options.runs):
        output = subprocess.run(
            [sys.executable, *sys.argv, "--one"], check=True, stdout=subprocess.PIPE
        ).stdout
        runs.append(json.loads(output))
    print(head("", "median"))
    for name in runs[0]:
        print(row(name, median(run[name] for run in runs)))


if __name__ == "__main__":
    main()
