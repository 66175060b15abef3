"""Where a robot starts and where it is to go, drawn from a scenario's seed."""

import math
from typing import Callable, List, Optional, Tuple

import numpy as np

from flatland_server.arrays import FloatArray
from flatland_server.exceptions import UsageError
from flatland_server.geometry import Point, Pose
from flatland_server.library.free_space import DistanceGrid, FreeSpace, discs_of
from flatland_server.library.handles import ModelHandle
from flatland_server.library.simulation import Simulation
from flatland_server.sweep.settings import RANDOM, Task

_TRIES = 200
_DRAWN = 256
"""Places that are drawn in each try."""

FreeSpaceCache = Callable[[Callable[[], FreeSpace]], FreeSpace]
"""Returns the free space of the world, kept; the argument computes it the first time."""


def draw_start_and_goal(
    simulation: Simulation, robot: ModelHandle, task: Task, seed: int, free_spaces: FreeSpaceCache
) -> Tuple[Pose, Optional[Point]]:
    """The start of a robot's origin and its goal: drawn where the task says random.

    Args:
        simulation: at time 0, with the robot where the world file puts it.
        robot: what is driven.
        task: what is to be done.
        seed: of the scenario. Equal seeds give equal places, whatever the controller is.
        free_spaces: keeps the free space of a world for the next scenario.

    Raises:
        UsageError: there is no room.
    """
    start, goal = task.start, task.goal
    if start != RANDOM and goal != RANDOM:
        return _given(robot, start), goal if isinstance(goal, tuple) else None
    rng = np.random.default_rng([seed, 0])
    space = free_spaces(lambda: _free_space(simulation, robot, task.margin))
    if space.area == 0.0:
        raise _no_room(task)
    if start != RANDOM:
        begin = _given(robot, start)
        goals = _at_distance(space.poses(_DRAWN * _TRIES, rng), begin[:2], task)
        return begin, _first(goals, task)[:2]
    if goal != RANDOM:
        end = goal if isinstance(goal, tuple) else None
        starts = space.poses(_DRAWN * _TRIES if end else 1, rng)
        return Pose(*_first(_at_distance(starts, end, task) if end else starts, task)), end
    for _ in range(_TRIES):
        begin = Pose(*_first(space.poses(1, rng), task))
        goals = _at_distance(space.poses(_DRAWN, rng), begin[:2], task)
        if len(goals):
            return begin, _first(goals, task)[:2]
    raise _no_room(task)


def _given(robot: ModelHandle, start: object) -> Pose:
    """The start that the task names, or the one of the world file."""
    return start if isinstance(start, Pose) else robot.model.pose


def _free_space(simulation: Simulation, robot: ModelHandle, margin: float) -> FreeSpace:
    """Where the robot can be, with a margin [m]."""
    walls = [layer.segments for layer in simulation.world.layers]
    others = [each.model for each in simulation.models.values() if each.name != robot.name]
    clearance = robot.model.radius + margin
    return DistanceGrid(
        np.concatenate([np.empty((0, 4)), *walls]),
        robot.model.pose[:2],
        clearance,
        discs=discs_of((model.pose, model.radius) for model in others),
    ).free_space(clearance)


def _at_distance(poses: FloatArray, middle: Point, task: Task) -> FloatArray:
    """Those poses that are as far from a point as start and goal may be."""
    apart = np.hypot(poses[:, 0] - middle[0], poses[:, 1] - middle[1])
    least, largest = task.goal_distance
    return np.asarray(poses[(apart >= least) & (apart <= largest)])


def _first(poses: FloatArray, task: Task) -> Tuple[float, float, float]:
    """The first of some poses.

    Raises:
        UsageError: there is none.
    """
    if not len(poses):
        raise _no_room(task)
    chosen: List[float] = poses[0].tolist()
    return chosen[0], chosen[1], math.remainder(chosen[2], math.tau)


def _no_room(task: Task) -> UsageError:
    least, largest = task.goal_distance
    return UsageError(
        f"no free start and goal were found that are {least:g} to {largest:g} m apart"
    )
