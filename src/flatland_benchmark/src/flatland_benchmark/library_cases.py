"""Programs without ROS: resets, a crowd, and an environment of Gymnasium."""

import time
from pathlib import Path
from statistics import median
from typing import Any, Callable, Dict

from flatland2d import Simulation, find_robot, world_content
from flatland_benchmark.case import Figures, case

_STEPS = 20
"""In a block; an environment makes ten times as many."""
_BLOCKS = 40


@case("library_reset_{world}", "resets of the world {world}", world=("office", "test_room"))
def reset(worlds: Path, world: str) -> Figures:
    """Processor time of a reset of a world as it comes, after a step."""
    with Simulation(worlds / world / "world.yaml") as sim:
        sim.reset().reset()  # the first ones make what later ones use again
        times = []
        for _ in range(_BLOCKS):
            begin = time.process_time()
            for _ in range(_STEPS):
                sim.step().reset()
            times.append(time.process_time() - begin)
    return {"step and reset [us]": median(times) / _STEPS * 1e6}


@case("library_crowd_{motion}", "200 people, {motion}", motion=("orca", "social_force"))
def walk_crowd(worlds: Path, motion: str) -> Figures:
    """Processor time of a crowd of 200 that crosses a circle, as a share of a core."""
    circle = {"count": 200, "radius": 25}
    crowd = {"type": "Crowd", "name": "people", "motion": motion, "circle": circle}
    world = {"properties": {}, "layers": [{"name": "map"}], "plugins": [crowd]}
    with Simulation(world) as simulation:
        begin = time.process_time()
        simulation.step(round(30.0 / simulation.step_size))
        return {"share of a core [%]": (time.process_time() - begin) / 30.0 * 100.0}


@case("environment_{beams}", "a step of gymnasium.make, {beams} beams", beams=(64, 360, 1081))
def step_environment(worlds: Path, beams: int) -> Figures:
    """Processor time of a step of the office; the robot turns on the spot.

    The least of alternating blocks: of the core's calls for a command, a step and a scan, of a
    `Simulation` with the same, of the environment, of that with Gymnasium's wrappers, and of that
    with episodes of a dozen steps and their resets.
    """
    import gymnasium
    import numpy as np

    import flatland_gym  # noqa: F401 (registers the environments)

    env, ending = (
        gymnasium.make("flatland/Navigation-v0", world="office", beams=beams, max_episode_steps=n)
        for n in (None, 12)
    )
    ending.reset(seed=0)
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
    roles: Any = found.drive.batch_role, found.lidar.batch_role
    physics, core_drive, core_lidar = sim.world.physics, roles[0].drive.drive, roles[1].lidar.lidar

    def step_core() -> None:
        core_drive.command(0.0, 0.0, 0.5)
        physics.step_until_contact(sim.step_size, 1)
        core_lidar.ranges()

    def simulate() -> None:
        drive.command(0.0, 0.5)
        sim.step()
        lidar.read()

    def step_and_reset() -> None:
        if any(ending.step(action)[2:4]):
            ending.reset()

    works: Dict[str, Callable[[], object]] = {
        "core [us]": step_core,
        "Simulation [us]": simulate,
        "environment [us]": lambda: inner.step(action),
        "with wrappers [us]": lambda: env.step(action),
        "with an end each 12 [us]": step_and_reset,
    }
    best = dict.fromkeys(works, float("inf"))
    for _ in range(_BLOCKS):
        for name, work in works.items():
            begin = time.process_time()
            for _ in range(10 * _STEPS):
                work()
            seconds = (time.process_time() - begin) / (10 * _STEPS)
            best[name] = min(best[name], seconds * 1e6)
    env.close()
    ending.close()
    sim.close()
    return best
