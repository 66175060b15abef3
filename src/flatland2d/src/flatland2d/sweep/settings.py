"""The content of a scenario file, and the scenarios that it stands for."""

from dataclasses import dataclass, field
from itertools import product
from pathlib import Path
from typing import Any, Dict, List, Mapping, Optional, Tuple, Union

from flatland_server.exceptions import UsageError
from flatland_server.geometry import Point, Pose

RANDOM = "random"
"""As a start or a goal: drawn from the scenario's seed, in free space."""


@dataclass(frozen=True)
class Task:
    """The start and the goal of a robot.

    Attributes:
        robot: the model that is driven; None: the only one with a drive, if there is one.
        start: of the robot; `RANDOM`, or None for the pose of the world file.
        goal: x, y [m]; `RANDOM`, or None for no goal.
        goal_radius: how near to the goal is a success [m].
        goal_distance: the least and the largest distance between start and goal [m], if one of them
            is random.
        margin: between the robot and all else, at a random start and goal [m].
        shortest_path: length of the shortest path to the goal [m]; None: it is computed.
        top_speed: of the robot [m/s], for the score of BARN; None: there is no such score.
    """

    robot: Optional[str] = None
    start: Union[str, Pose, None] = None
    goal: Union[str, Point, None] = None
    goal_radius: float = 0.3
    goal_distance: Tuple[float, float] = (1.0, 10.0)
    margin: float = 0.1
    shortest_path: Optional[float] = None
    top_speed: Optional[float] = None


@dataclass(frozen=True)
class SweepWorld:
    """An entry of `worlds`.

    Attributes:
        name: unique in the sweep.
        source: the name of a shipped world, or a file relative to the scenario file.
        task: of the robot in this world.
        group: name of the row of the summary that it belongs to; empty: it has its own.
    """

    name: str
    source: str
    task: Task
    group: str = ""


@dataclass(frozen=True)
class Controller:
    """An entry of `controllers`.

    Attributes:
        name: unique in the sweep.
        target: the function, as "module:function" or "file.py:function"; empty: the world runs by
            itself.
        arguments: keyword arguments of the function.
        policy: the file of a policy, relative to the scenario file, that the function drives by;
            empty if there is none.
    """

    name: str
    target: str = ""
    arguments: Mapping[str, Any] = field(default_factory=dict)
    policy: str = ""


@dataclass(frozen=True)
class SweepSettings:
    """The content of a scenario file.

    Attributes:
        file: the scenario file.
        worlds: at least one.
        controllers: at least one.
        seeds: of the scenarios, at least one.
        parameters: the values by their names, one mapping for each combination, at least one.
        step_size: of the physics [s].
        control_period: between two actions of a controller [s].
        time_limit: of a scenario, in simulated time [s].
        real_time_limit: after which a scenario that does not end is stopped [s].
        collision_ends: whether a collision ends a scenario.
        retries: how often a scenario is run again after its worker has died.
    """

    file: Path
    worlds: Tuple[SweepWorld, ...]
    controllers: Tuple[Controller, ...]
    seeds: Tuple[int, ...]
    parameters: Tuple[Mapping[str, Any], ...]
    step_size: float = 0.005
    control_period: float = 0.05
    time_limit: float = 60.0
    real_time_limit: float = 600.0
    collision_ends: bool = True
    retries: int = 2

    @property
    def folder(self) -> Path:
        """The folder that paths in the file are relative to."""
        return self.file.parent


@dataclass(frozen=True)
class Scenario:
    """One world, controller, combination of parameters and seed.

    Attributes:
        number: from 1, in the order of the table.
        world: that is simulated.
        controller: that drives the robot.
        parameters: values by name.
        seed: of all its random numbers.
    """

    number: int
    world: SweepWorld
    controller: Controller
    parameters: Mapping[str, Any]
    seed: int

    @property
    def group(self) -> Dict[str, Any]:
        """Of the summary: world or its group, controller and parameters."""
        world = self.world.group or self.world.name
        return {"world": world, "controller": self.controller.name, **self.parameters}

    @property
    def columns(self) -> Dict[str, Any]:
        """The columns that identify it, by their names."""
        numbered = {"scenario": self.number, **self.group, "seed": self.seed}
        return {**numbered, "world": self.world.name}

    def __str__(self) -> str:
        values = "".join(f"{name} = {value}, " for name, value in self.parameters.items())
        return (
            f"scenario {self.number} (world {self.world.name}, controller {self.controller.name}, "
            f"{values}seed {self.seed})"
        )


def scenarios_of(settings: SweepSettings) -> List[Scenario]:
    """All scenarios: by world, controller, parameters, and seed."""
    combined = product(settings.worlds, settings.controllers, settings.parameters, settings.seeds)
    return [Scenario(number, *each) for number, each in enumerate(combined, start=1)]


def scenario_of(settings: SweepSettings, number: int) -> Scenario:
    """The scenario with a number.

    Raises:
        UsageError: there is none.
    """
    scenarios = scenarios_of(settings)
    if not 1 <= number <= len(scenarios):
        raise UsageError(f"expected a scenario of 1 to {len(scenarios)}, found {number}")
    return scenarios[number - 1]
