"""Steps of one environment of the office, as `gymnasium.make` makes it, by beams of its lidar.

    usage: single_environment.py [--blocks 40]

Needs Flatland and its extra gym. The robot turns on the spot. Figures are the least processor time
of alternating blocks: of the core's calls for a command, a step and a scan, of a `Simulation` with
the same, of the environment, and of the environment with Gymnasium's wrappers.
"""

import argparse
import time
from typing import Callable, Dict

import gymnasium
import numpy as np

import flatland_gym  # noqa: F401 (registers the environments)
from flatland2d import Simulation, find_robot, world_content

_STEPS = 200
"""Steps of a block."""


def measure(beams: int, blocks: int) -> Dict[str, float]:
    """Processor time of a step [us]."""
    env = gymnasium.make("flatland/Navigation-v0", world="office", beams=beams)
    _, info = env.reset(seed=0)
    inner, action = env.unwrapped, np.array([0.0, 0.5], np.float32)
    content = world_content("office")
    for model in content["models"]:
        for plugin in model["model"].get("plugins", ()):
            if plugin["type"] == "Laser":
                plugin["angle"] = {"min": -2.356, "max": 2.356, "increment": 4.712 / (beams - 1)}
    sim = Simulation(content, step_size=0.05)
    found = find_robot(sim.world)
    robot = sim.models[found.model.name]
    drive, lidar = robot.drives[found.drive.name], robot.sensors[found.lidar.name]
    sim.move(robot.name, info["pose"])

    physics, core_drive = sim.world.physics, found.drive.batch_role.drive.drive
    core_lidar = found.lidar.batch_role.lidar.lidar

    def step_core() -> None:
        core_drive.command(0.0, 0.0, 0.5)
        physics.step_until_contact(sim.step_size, 1)
        core_lidar.ranges()

    def simulate() -> None:
        drive.command(0.0, 0.5)
        sim.step()
        lidar.read()

    works: Dict[str, Callable[[], object]] = {
        "core": step_core,
        "Simulation": simulate,
        "environment": lambda: inner.step(action),
        "with Gymnasium's wrappers": lambda: env.step(action),
    }
    best = dict.fromkeys(works, float("inf"))
    for _ in range(blocks):
        for name, work in works.items():
            begin = time.process_time()
            for _ in range(_STEPS):
                work()
            best[name] = min(best[name], (time.process_time() - begin) / _STEPS * 1e6)
    env.close()
    sim.close()
    return best


def main() -> None:
    """Prints a table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--blocks", type=int, default=40)
    blocks = parser.parse_args().blocks
    for beams in (64, 360, 1081):
        found = measure(beams, blocks)
        if beams == 64:
            print("| beams |", " | ".join(f"{name} [us]" for name in found), "| steps/s |")
            print("| --- " * (len(found) + 2) + "|")
        rate = 1e6 / found["with Gymnasium's wrappers"]
        print(f"| {beams} |", " | ".join(f"{us:.1f}" for us in found.values()), f"| {rate:,.0f} |")


if __name__ == "__main__":
    main()
