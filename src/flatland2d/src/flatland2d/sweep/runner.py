"""Runs scenarios in this process, one after the other."""

import json
import math
import os
import sys
import traceback
from collections import OrderedDict
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, List, Mapping, Optional, Set, Tuple

import numpy as np

from flatland2d.free_space import DistanceGrid, FreeSpace, discs_of
from flatland2d.handles import ModelHandle
from flatland2d.robot import driven_models
from flatland2d.simulation import Simulation
from flatland2d.sweep.controllers import arguments_of, find_controller
from flatland2d.sweep.parameters import SweepWorlds, world_key, world_params
from flatland2d.sweep.run import ESTIMATE_ENDS, OTHER_COLUMNS, RunObserver, RunOver, SweepRun
from flatland2d.sweep.settings import RANDOM, Scenario, SweepSettings, SweepWorld, Task
from flatland2d.sweep.shortest_path import shortest_path
from flatland_server.arrays import FloatArray
from flatland_server.exceptions import FlatlandError, UsageError, shortened
from flatland_server.geometry import Point, Pose
from flatland_server.simulation import WorldConfig

_KEPT_WORLDS = 4
"""The number of worlds that stay loaded; scenarios come world by world."""

_LONGEST_ERROR = 300

_TRIES = 200
_DRAWN = 256
"""The number of places drawn in each try."""

Row = Dict[str, Any]
"""The result of a scenario: None, booleans, numbers and strings by the names of columns."""


@dataclass(frozen=True)
class Result:
    """The result of a scenario. Equal scenarios have equal results.

    Attributes:
        row: the measured values; empty if it was not run to the end.
        returned: the values that the controller has returned, by name.
        error: why it could not be run to the end; empty if it was.
        traceback: of an exception of the controller.
        seconds: of real time that the sweep has needed for it.
        attempts: how often the sweep has begun it.
    """

    row: Row
    returned: Row
    error: str = ""
    traceback: str = ""
    seconds: float = 0.0
    attempts: int = 0


class ScenarioRunner:
    """Runs scenarios of a sweep, and keeps the worlds that it has read."""

    def __init__(self, settings: SweepSettings) -> None:
        self._settings = settings
        self._reader = SweepWorlds(settings.folder)
        self._worlds: OrderedDict[Tuple[str, Optional[int]], WorldConfig] = OrderedDict()
        self._random_worlds: Set[str] = set()  # those that depend on the seed

    def run(self, scenario: Scenario, *observers: RunObserver) -> Result:
        """Runs a scenario.

        Returns:
            The result; also if the controller raises an exception.

        Raises:
            FlatlandError: an observer cannot begin.
        """
        with ExitStack() as stack:
            try:
                simulation = stack.enter_context(self._open(scenario))
                run = self._prepare(scenario, simulation, observers)
            except FlatlandError as error:
                return _without_row(error)
            for observer in observers:
                observer.on_begin(run)
            try:
                result = self._drive(scenario, run)
            except FlatlandError as error:
                return _without_row(error)
            for observer in observers:
                observer.on_end(run)
            return result

    def _open(self, scenario: Scenario) -> Simulation:
        """A simulation of the scenario's world.

        Raises:
            FlatlandError: something in its files is wrong.
        """
        source, params = scenario.world.source, world_params(scenario.parameters)
        name = world_key(source, scenario.parameters)
        key = name, scenario.seed if name in self._random_worlds else None
        if key not in self._worlds:
            content = self._reader.content(source, scenario.parameters, scenario.seed)
            if self._reader.is_random:
                self._random_worlds.add(name)
                key = name, scenario.seed
            self._worlds[key] = WorldConfig.from_content(content)
            if len(self._worlds) > _KEPT_WORLDS:
                self._worlds.popitem(last=False)
        self._worlds.move_to_end(key)
        step_size = self._settings.step_size
        return Simulation(self._worlds[key], seed=scenario.seed, step_size=step_size, params=params)

    def _prepare(
        self, scenario: Scenario, simulation: Simulation, observers: Tuple[RunObserver, ...]
    ) -> SweepRun:
        """Puts the robot to its start, and returns the run.

        Raises:
            FlatlandError: there is no robot, or no room for it.
        """
        task = scenario.world.task
        robot = _robot_of(simulation, scenario.world)
        goal = shortest = None
        if robot is not None:
            start, goal = _draw_start_and_goal(simulation, robot, task, scenario.seed)
            if task.start is not None:
                simulation.move(robot.name, start)
            shortest = task.shortest_path
            if goal is not None and shortest is None:
                shortest = shortest_path(simulation, robot, goal, task.goal_radius)
        return SweepRun(
            simulation,
            self._settings,
            task,
            robot=robot,
            goal=goal,
            shortest=shortest,
            seed=scenario.seed,
            parameters=scenario.parameters,
            observers=observers,
        )

    def _drive(self, scenario: Scenario, run: SweepRun) -> Result:
        """Runs the controller, and collects the result."""
        folder = self._settings.folder
        function = find_controller(scenario.controller, folder)
        arguments = arguments_of(scenario.controller, function, scenario.parameters, folder)
        returned: Any = None
        process = os.getpid()
        try:
            returned = function(run, **arguments)
        except RunOver:
            pass
        except (Exception, SystemExit) as error:
            return _failed(run, error)
        finally:
            if os.getpid() != process:  # forked by the controller: this process has no result
                os._exit(0)
        run.end()
        row = run.metrics()
        columns = _checked_columns(returned, {*row, *scenario.columns, *OTHER_COLUMNS})
        if "success" in columns:
            row["success"] = columns.pop("success")
        return Result(row, columns)


def _without_row(error: FlatlandError) -> Result:
    return Result({}, {}, shortened(str(error), _LONGEST_ERROR))


def _failed(run: SweepRun, error: BaseException) -> Result:
    """The result of a run that an exception has ended."""
    run.outcome = "error"
    frames = traceback.extract_tb(error.__traceback__)
    place = f" ({Path(frames[-1].filename).name}:{frames[-1].lineno})" if frames else ""
    if isinstance(error, FlatlandError):  # its message is enough
        place = ""
    reason = f"{type(error).__name__}: {error}{place}"
    text = "".join(traceback.format_exception(type(error), error, error.__traceback__))
    return Result(run.metrics(), {}, shortened(reason, _LONGEST_ERROR), text)


def _checked_columns(returned: Any, taken: Set[str]) -> Row:
    """The values that a controller has returned, by name.

    Args:
        returned: what the controller has returned.
        taken: names of other columns.

    Raises:
        UsageError: it is no mapping of names to plain values, or a name is taken.
    """
    if returned is None:
        return {}
    if not isinstance(returned, Mapping):
        raise UsageError(
            "expected the controller to return None or a dict of numbers, booleans and strings, "
            f"found {shortened(repr(returned))}"
        )
    columns: Row = {}
    for name, value in returned.items():
        if hasattr(value, "tolist"):  # of NumPy
            value = value.tolist()
        kinds = (type(None), bool) if name == "success" else (type(None), bool, int, float, str)
        if not isinstance(name, str) or not isinstance(value, kinds):
            raise UsageError(
                "expected the controller to return numbers, booleans and strings by name, and "
                f"success as a boolean, found {name!r}: {shortened(repr(value))}"
            )
        if name != "success" and name in taken | {
            f"{other}{end}" for other in (*taken, *returned) for end in ESTIMATE_ENDS
        }:
            raise UsageError(f'the controller returns "{name}", which is a column already')
        if isinstance(value, int) and abs(value) > sys.float_info.max:
            raise UsageError(f"expected numbers below 1.8e308, found a larger one: {name!r}")
        columns[name] = value
    plain: Row = json.loads(json.dumps(columns))  # without a controller's own types of values
    return plain


# The robot, its start and its goal


def _robot_of(simulation: Simulation, world: SweepWorld) -> Optional[ModelHandle]:
    """The robot of a world.

    Raises:
        UsageError: the task needs one, and there is none, or there are several.
    """
    task = world.task
    if task.robot is not None:
        return simulation.models[task.robot]
    robots = driven_models(simulation.world)
    if len(robots) == 1:
        return simulation.models[robots[0]]
    if task.start == RANDOM or task.goal is not None:
        found = ", ".join(robots) or "none"
        raise UsageError(
            f'expected a model with a drive in the world "{world.name}", or the key "robot" to '
            f"name one of several; found {found}"
        )
    return None


def _draw_start_and_goal(
    simulation: Simulation, robot: ModelHandle, task: Task, seed: int
) -> Tuple[Pose, Optional[Point]]:
    """The start of a robot's origin and its goal: drawn where the task says random.

    Args:
        simulation: at time 0, with the robot where the world file puts it.
        robot: the driven model.
        task: the robot's task.
        seed: of the scenario. Equal seeds give equal places, whatever the controller is.

    Raises:
        UsageError: there is no room.
    """
    given = task.start if isinstance(task.start, Pose) else robot.model.pose
    goal = task.goal if isinstance(task.goal, tuple) else None
    if RANDOM not in (task.start, task.goal):
        return given, goal
    rng = np.random.default_rng([seed, 0])
    space = _free_space(simulation, robot, task.margin)
    if space.area == 0.0:
        raise _no_room(task)
    if task.start != RANDOM:
        goals = _at_distance(space.poses(_DRAWN * _TRIES, rng), given[:2], task)
        return given, _first(goals, task)[:2]
    if task.goal is None:
        return Pose(*_first(space.poses(1, rng), task)), None
    if goal is not None:
        starts = _at_distance(space.poses(_DRAWN * _TRIES, rng), goal, task)
        return Pose(*_first(starts, task)), goal
    for _ in range(_TRIES):
        start = Pose(*_first(space.poses(1, rng), task))
        goals = _at_distance(space.poses(_DRAWN, rng), start[:2], task)
        if len(goals):
            return start, _first(goals, task)[:2]
    raise _no_room(task)


def _free_space(simulation: Simulation, robot: ModelHandle, margin: float) -> FreeSpace:
    """The free space of the robot, with a margin [m]."""
    walls = [layer.segments for layer in simulation.world.layers]
    others = [each.model for each in simulation.models.values() if each.name != robot.name]
    clearance = robot.model.radius + margin
    return DistanceGrid.shared(
        np.concatenate([np.empty((0, 4)), *walls]),
        robot.model.pose[:2],
        clearance,
        discs=discs_of((model.pose, model.radius) for model in others),
    ).free_space(clearance)


def _at_distance(poses: FloatArray, middle: Point, task: Task) -> FloatArray:
    """The poses at a distance from a point that the task allows between start and goal."""
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
