"""Environments of Gymnasium: a step of one, and many steps of `make_vec` with their creation."""

import time
from pathlib import Path
from typing import Any, Callable, Dict

import numpy as np

from flatland2d import Simulation, find_robot, world_content
from flatland_benchmark.case import Figures, case

_STEPS = 200
"""In a block."""
_BLOCKS = 40


@case("environment_{beams}", "a step of gymnasium.make, {beams} beams", beams=(64, 360, 1081))
def step_environment(worlds: Path, beams: int) -> Figures:
    """Processor time of a step of the office; the robot turns on the spot.

    The least of alternating blocks: of the core's calls for a command, a step and a scan, of the
    environment, and of one with Gymnasium's wrappers, episodes of a dozen steps and their resets.
    """
    import gymnasium

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
    robot = find_robot(sim.world)
    sim.move(robot.model.name, info["pose"])
    roles: Any = robot.drive.batch_role, robot.lidar.batch_role
    physics, drive, lidar = sim.world.physics, roles[0].drive.drive, roles[1].lidar.lidar

    def step_core() -> None:
        drive.command(0.0, 0.0, 0.5)
        physics.step_until_contact(sim.step_size, 1)
        lidar.ranges()

    def step_and_reset() -> None:
        if any(ending.step(action)[2:4]):
            ending.reset()

    works: Dict[str, Callable[[], object]] = {
        "core [us]": step_core,
        "environment [us]": lambda: inner.step(action),
        "with an end each 12 [us]": step_and_reset,
    }
    best = dict.fromkeys(works, float("inf"))
    for _ in range(_BLOCKS):
        for name, work in works.items():
            begin = time.process_time()
            for _ in range(_STEPS):
                work()
            best[name] = min(best[name], (time.process_time() - begin) / _STEPS * 1e6)
    env.close()
    ending.close()
    sim.close()
    return best


_TRAININGS: Dict[str, Dict[str, Any]] = {
    "office": {"world": "office", "beams": 360},
    "corridor": {"world": "corridor"},
    "crossing": {"world": "crossing", "num_envs": 256},
    "empty_room": {"world": "empty_room"},
    "maps": {"world": "empty_room", "num_maps": 300},
    "teams": {"world": "empty_room", "robots": 8},
}
"""Arguments of the environments, by the names of cases."""
_FIRST, _MILLION = 20_000, 1_000_000
_HELD = 10
"""Steps with the same random actions."""


@case("training_{kind}", "a million steps of make_vec: {kind}", kind=tuple(_TRAININGS))
def train(worlds: Path, kind: str) -> Figures:
    """Steps with resets, observations and rewards, as a learner makes them, on random actions.

    A team makes as many steps as it has robots that drive.
    """
    begin = time.perf_counter()
    env = _vector_env(**_TRAININGS[kind])
    env.reset(seed=0)
    created, created_cpu = time.perf_counter(), time.process_time()
    figures: Figures = {"creation [s]": created - begin}
    rng, space, made, step = np.random.default_rng(0), env.action_space, 0, 0
    for count in (_FIRST, _MILLION):
        while made < count:
            if step % _HELD == 0:
                actions = rng.uniform(space.low, space.high)
            infos = env.step(actions)[-1]
            made += int(infos["present"].sum()) if "present" in infos else env.num_envs
            step += 1
        now = time.perf_counter()
        figures[f"steps/s, {count:,}"] = made / (now - created)
        figures[f"with creation, {count:,}"] = made / (now - begin)
    figures["CPU per step [us]"] = (time.process_time() - created_cpu) / made * 1e6
    env.close()
    return figures


def _vector_env(*, num_envs: int = 1024, beams: int = 64, **arguments: Any) -> Any:
    """Environments of one robot, or of a team."""
    import gymnasium

    from flatland_gym import Rooms
    from flatland_gym.multi_robot_vector_env import MultiRobotVectorEnv

    if "robots" in arguments:
        return MultiRobotVectorEnv(num_envs=num_envs, beams=beams, **arguments)
    if "num_maps" in arguments:
        arguments["maps"] = Rooms()
    return gymnasium.make_vec("flatland/Navigation-v0", num_envs, beams=beams, **arguments)
