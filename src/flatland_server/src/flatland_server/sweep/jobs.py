"""The jobs of workers: the result of a scenario, or a picture of its run."""

from dataclasses import dataclass
from typing import Union

from flatland_server.sweep.pictures import picture_of
from flatland_server.sweep.runner import Result, ScenarioRunner
from flatland_server.sweep.scenario import Scenario
from flatland_server.sweep.settings import SweepSettings

Answer = Union[Result, bytes]
"""A result; or the content of a PNG file, which is empty if the run could not be drawn."""


@dataclass(frozen=True)
class Job:
    """A scenario to run.

    Attributes:
        scenario: what is run.
        is_picture: whether a picture of the run is asked for, not its result.
    """

    scenario: Scenario
    is_picture: bool = False


class JobRunner:
    """Does jobs in this process.

    Args:
        settings: of the sweep.
    """

    def __init__(self, settings: SweepSettings) -> None:
        self._runner = ScenarioRunner(settings)

    def run(self, job: Job) -> Answer:
        """The answer to a job."""
        if job.is_picture:
            return picture_of(self._runner, job.scenario)
        return self._runner.run(job.scenario)
