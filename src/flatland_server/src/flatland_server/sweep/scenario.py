"""Scenarios: what a sweep consists of, in a fixed order."""

from dataclasses import dataclass
from itertools import product
from typing import Any, Dict, List, Mapping

from flatland_server.exceptions import UsageError
from flatland_server.sweep.settings import Controller, SweepSettings, SweepWorld


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
        """World, controller and parameters: the columns that do not depend on the seed."""
        names = {"world": self.world.name, "controller": self.controller.name}
        return {**names, **self.parameters}

    @property
    def columns(self) -> Dict[str, Any]:
        """The columns that identify it, by their names."""
        return {"scenario": self.number, **self.group, "seed": self.seed}

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
    """The scenario of a number.

    Raises:
        UsageError: there is none.
    """
    scenarios = scenarios_of(settings)
    if not 1 <= number <= len(scenarios):
        raise UsageError(f"expected a scenario of 1 to {len(scenarios)}, found {number}")
    return scenarios[number - 1]
