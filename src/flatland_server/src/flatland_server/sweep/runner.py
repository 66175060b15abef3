"""Runs scenarios in this process, one after the other."""

import traceback
from collections import OrderedDict
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable, Container, Dict, Mapping, Optional, Tuple

from flatland_server.exceptions import FlatlandError, UsageError, shortened
from flatland_server.library.free_space import FreeSpace
from flatland_server.library.handles import ModelHandle
from flatland_server.library.simulation import Simulation
from flatland_server.simulation.world_config import WorldConfig
from flatland_server.sweep.controllers import arguments_of, find_controller
from flatland_server.sweep.parameters import world_key, world_params
from flatland_server.sweep.run import RunObserver, RunOver, SweepRun
from flatland_server.sweep.scenario import Scenario
from flatland_server.sweep.settings import RANDOM, SweepSettings, SweepWorld
from flatland_server.sweep.start_and_goal import draw_start_and_goal
from flatland_server.sweep.sweep_worlds import SweepWorlds

_KEPT_WORLDS = 4
"""Worlds that stay loaded: scenarios come world by world."""

_LONGEST_ERROR = 300

_NO_OBSERVER = RunObserver()

Row = Dict[str, Any]
"""The result of a scenario: None, booleans, numbers and strings by the names of columns."""


@dataclass(frozen=True)
class Result:
    """The result of a scenario. Equal scenarios have equal results.

    Attributes:
        row: what was measured; empty if it was not run to the end.
        returned: what the controller has returned, by name.
        error: why it could not be run to the end; empty if it was.
        traceback: of an exception of the controller.
    """

    row: Row
    returned: Row
    error: str = ""
    traceback: str = ""


@dataclass
class _Loaded:
    """A world as it was read, and where its robot can be."""

    config: WorldConfig
    params: Mapping[str, Any]
    free_space: Dict[Tuple[str, float], FreeSpace]


class ScenarioRunner:
    """Runs scenarios of a sweep, and keeps the worlds that it has read.

    Args:
        settings: of the sweep.
    """

    def __init__(self, settings: SweepSettings) -> None:
        self._settings = settings
        self._reader = SweepWorlds(settings.folder)
        self._worlds: OrderedDict[str, _Loaded] = OrderedDict()

    def run(self, scenario: Scenario, observer: RunObserver = _NO_OBSERVER) -> Result:
        """Runs a scenario.

        Args:
            scenario: of the sweep.
            observer: looks at the run; it changes nothing.

        Returns:
            The result; also if the controller raises an exception.

        Raises:
            FlatlandError: the observer cannot begin.
        """
        with ExitStack() as stack:
            try:
                simulation = stack.enter_context(self.open(scenario))
                run = self.prepare(scenario, simulation, observer)
            except FlatlandError as error:
                return _without_row(error)
            observer.on_begin(run)
            try:
                result = self._drive(scenario, run)
            except FlatlandError as error:
                return _without_row(error)
            observer.on_end(run)
            return result

    def close(self) -> None:
        """Ends the process that evaluates expressions in the worlds' files."""
        self._reader.close()

    def open(self, scenario: Scenario) -> Simulation:
        """A simulation of the scenario's world.

        Raises:
            FlatlandError: something in its files is wrong.
        """
        loaded = self._load(scenario)
        return Simulation(
            loaded.config,
            seed=scenario.seed,
            step_size=self._settings.step_size,
            params=loaded.params,
        )

    def prepare(
        self, scenario: Scenario, simulation: Simulation, observer: RunObserver = _NO_OBSERVER
    ) -> SweepRun:
        """Puts the robot to its start, and returns the run.

        Raises:
            FlatlandError: there is no robot, or no room for it.
        """
        task = scenario.world.task
        robot = _robot_of(simulation, scenario.world)
        goal = None
        if robot is not None:
            kept = self._load(scenario).free_space
            key = (robot.name, task.margin)

            def free_space(make: Callable[[], FreeSpace]) -> FreeSpace:
                if key not in kept:
                    kept[key] = make()
                return kept[key]

            start, goal = draw_start_and_goal(simulation, robot, task, scenario.seed, free_space)
            if task.start is not None:
                simulation.move(robot.name, start)
        return SweepRun(
            simulation,
            self._settings,
            task,
            robot=robot,
            goal=goal,
            seed=scenario.seed,
            parameters=scenario.parameters,
            observer=observer,
        )

    def _drive(self, scenario: Scenario, run: SweepRun) -> Result:
        """Runs the controller, and collects the result."""
        folder = self._settings.folder
        function = find_controller(scenario.controller, folder)
        arguments = arguments_of(scenario.controller, function, scenario.parameters, folder)
        returned: Any = None
        try:
            returned = function(run, **arguments)
        except RunOver:
            pass
        except FlatlandError as error:
            return _failed(run, f"{type(error).__name__}: {error}", error)
        except (Exception, SystemExit) as error:
            return _failed(run, f"{type(error).__name__}: {error}{_place_of(error)}", error)
        run.end()
        row = run.metrics()
        columns = _checked_columns(returned, {*row, *scenario.columns, "status", "error"})
        if "success" in columns:
            row["success"] = columns.pop("success")
        return Result(row, columns)

    def _load(self, scenario: Scenario) -> _Loaded:
        """The scenario's world, read when it is needed first."""
        key = world_key(scenario.world.source, scenario.parameters)
        if key in self._worlds:
            self._worlds.move_to_end(key)
            return self._worlds[key]
        content = self._reader.content(scenario.world.source, scenario.parameters)
        params = world_params(scenario.parameters)
        loaded = _Loaded(WorldConfig.from_content(content), params, {})
        self._worlds[key] = loaded
        while len(self._worlds) > _KEPT_WORLDS:
            self._worlds.popitem(last=False)
        return loaded


def _robot_of(simulation: Simulation, world: SweepWorld) -> Optional[ModelHandle]:
    """The robot of a world.

    Raises:
        UsageError: the task needs one, and there is none, or there are several.
    """
    task = world.task
    if task.robot is not None:
        return simulation.models[task.robot]
    robots = [name for name, handle in simulation.models.items() if len(handle.drives)]
    if len(robots) == 1:
        return simulation.models[robots[0]]
    if task.start == RANDOM or task.goal is not None:
        found = ", ".join(robots) or "none"
        raise UsageError(
            f'expected a model with a drive in the world "{world.name}", or the key "robot" to '
            f"name one of several; found {found}"
        )
    return None


def _without_row(error: FlatlandError) -> Result:
    return Result({}, {}, shortened(str(error), _LONGEST_ERROR))


def _failed(run: SweepRun, reason: str, error: BaseException) -> Result:
    run.outcome = "error"
    text = "".join(traceback.format_exception(type(error), error, error.__traceback__))
    return Result(run.metrics(), {}, shortened(reason, _LONGEST_ERROR), text)


def _place_of(error: BaseException) -> str:
    """Where an exception was raised: the file and line of the innermost call."""
    frames = traceback.extract_tb(error.__traceback__)
    return f" ({Path(frames[-1].filename).name}:{frames[-1].lineno})" if frames else ""


def _checked_columns(returned: Any, taken: Container[str]) -> Row:
    """What a controller has returned, as plain values by name.

    Args:
        returned: by the controller.
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
        if not isinstance(name, str) or not (
            value is None or isinstance(value, (bool, int, float, str))
        ):
            raise UsageError(
                "expected the controller to return numbers, booleans and strings by name, found "
                f"{name!r}: {shortened(repr(value))}"
            )
        if name == "success" and not (value is None or isinstance(value, bool)):
            raise UsageError(f'expected the controller to return "success" as a bool: {value!r}')
        if name in taken and name != "success":
            raise UsageError(f'the controller returns "{name}", which is a column already')
        columns[name] = value
    return columns
