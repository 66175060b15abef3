"""The run of a scenario, as its controller sees it: the simulation, the robot, the goal, time."""

import math
from typing import Any, Dict, List, Mapping, Optional, Sequence, cast

import numpy as np

from flatland2d.handles import ModelHandle
from flatland2d.simulation import Simulation
from flatland2d.sweep.metrics import METRICS, barn_score, motion_metrics
from flatland2d.sweep.people import ZONES, PeopleMetrics, Twist
from flatland2d.sweep.settings import SweepSettings, Task
from flatland2d.touch import Touch
from flatland_navigation.score import GoalScore, spl
from flatland_server import _core
from flatland_server.arguments import steps_in
from flatland_server.config import LARGEST
from flatland_server.exceptions import UsageError
from flatland_server.geometry import Point, Pose, wrap_angle

OTHER_COLUMNS = ("status", "error", "scenarios", "failed")
"""The columns of rows and of the summary that are no metrics and do not belong to a scenario."""

ESTIMATE_ENDS = ("_low", "_high", "_count")
"""The ends of the names of columns beside that of a rate or mean."""

SCORED = ("contacts", "speed_change", "turn_change", "localization_error", "max_localization_error")
"""The metrics that a `GoalScore` has."""


class RunObserver:
    """The base of observers of runs; its methods do nothing, and must change nothing."""

    def on_begin(self, run: "SweepRun") -> None:
        """Called before the first step."""

    def on_step(self, run: "SweepRun") -> None:
        """Called after each step of the physics."""

    def on_end(self, run: "SweepRun") -> None:
        """Called after the last step, before the simulation is closed."""


class RunOver(BaseException):
    """Ends a controller that goes on stepping after the run is over.

    No Exception, so that no controller handles it.
    """


class SweepRun:
    """A scenario while it is simulated. A controller commands the robot and calls `step`.

        def towards_the_goal(run, speed=0.5):
            while run.is_running:
                run.robot.command(speed, run.bearing)
                run.step()

    The run is over when the robot has reached the goal or collided, when the time is up, or when
    the controller returns.

    Args:
        simulation: the simulation to run, at time 0.
        settings: the sweep's settings.
        task: the robot's task.
        robot: the driven model; None for a world that runs by itself.
        goal: x, y [m]; None if there is none.
        shortest: length of the shortest path to the goal [m]; None if it is not known.
        seed: seed of the robots' places and commands; see `Scenario`.
        parameters: of the scenario, by name.
        observers: called at each step.

    Attributes:
        simulation: the world; see `Simulation`. Its time passes by `step` of the run.
        robot: handle of the robot.
        goal: x, y [m], or None.
        goal_radius: how near to the goal the robot has arrived [m].
        seed: the scenario's seed.
        parameters: values of the sweep's parameters in this scenario, by name.
        rng: random numbers for the controller, seeded by the scenario.
        path: positions of the robot at the beginning and after each `step` [m].
        outcome: how it has ended: "goal", "collision", "time limit", "returned"; "" before.
    """

    def __init__(
        self,
        simulation: Simulation,
        settings: SweepSettings,
        task: Task,
        *,
        robot: Optional[ModelHandle] = None,
        goal: Optional[Point] = None,
        shortest: Optional[float] = None,
        seed: int = 0,
        parameters: Mapping[str, Any] = {},
        observers: Sequence[RunObserver] = (),
    ) -> None:
        self.simulation = simulation
        self.goal = goal
        self.seed = seed
        self.parameters = dict(parameters)
        self.rng = np.random.default_rng([seed, 1])
        self.outcome = ""
        self.path: List[Point] = []
        self._robot = robot
        self._settings = settings
        self.goal_radius = task.goal_radius
        self._limit = steps_in(settings.time_limit, settings.step_size, "time_limit")
        self._steps = 0
        self._observers = observers
        self._collided_with = ""
        self._has_arrived = False
        self._length = 0.0
        self._clearance = math.inf
        self._start = Pose()
        self._times: List[float] = []
        self._poses: List[Pose] = []
        self._shortest = shortest
        self._top_speed = task.top_speed
        if robot is not None:
            self._body = robot.model.base.physics_body
            self._drive = _drive_of(simulation, robot)
            self._score = GoalScore(1, shortest)
            self._touched = False
            self._start = robot.pose
            self._place = self._start[:2]
            self._people = PeopleMetrics(simulation.world, robot.model)
            self._note_pose()
            self._bodies = _core.BodyGroup(robot.model.physics_bodies)
            self._measure_clearance()

    @property
    def robot(self) -> ModelHandle:
        """Handle of the robot.

        Raises:
            UsageError: the world has no robot, or several ones and the scenario file names none.
        """
        if self._robot is None:
            raise UsageError('expected a model with a drive; name one of several by "robot"')
        return self._robot

    @property
    def is_running(self) -> bool:
        """True if the run goes on."""
        return not self.outcome

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.simulation.time

    @property
    def distance(self) -> float:
        """Distance from the origin of the robot's first body to the goal [m]; NaN without one."""
        if self.goal is None:
            return math.nan
        return math.dist(self.robot.pose[:2], self.goal)

    @property
    def bearing(self) -> float:
        """Bearing of the goal, positive to the left of the heading [rad]; NaN without a goal."""
        if self.goal is None:
            return math.nan
        x, y, yaw = self.robot.pose
        return wrap_angle(math.atan2(self.goal[1] - y, self.goal[0] - x) - yaw)

    def step(self, duration: Optional[float] = None) -> bool:
        """Advances the time, at most until the run is over.

        Args:
            duration: a multiple of the step size [s]; by default the control period.

        Returns:
            Whether the run goes on. If it did not before, this does not return: the controller
            ends.

        Raises:
            UsageError: the duration is no multiple of the step size.
            PluginError: a plugin has failed.
        """
        if self.outcome:
            raise RunOver()
        if duration is None:
            duration = self._settings.control_period
        for _ in range(steps_in(duration, self.simulation.step_size, "the duration")):
            before = self._people.velocities() if self._robot is not None else {}
            self.simulation.step()
            self._measure(before)
            for observer in self._observers:
                observer.on_step(self)
            if self.outcome:
                break
        if self._robot is not None:
            if self._drive is not None:
                self._score.add_command(*self._drive.target)
            self._note_pose()
            self._measure_clearance()
        return self.is_running

    def note_estimate(self, x: float, y: float) -> None:
        """Tells where the controller believes the robot to be, for `localization_error`.

        Args:
            x: of the origin of its first body [m].
            y: likewise [m].

        Raises:
            UsageError: a number is not finite, or farther than 1e9 m.
        """
        if not all(abs(each) <= LARGEST for each in (x, y)):  # or NaN
            raise UsageError(f"expected an estimate within {LARGEST:g} m, found ({x:g}, {y:g})")
        self._score.add_error(math.dist(self.robot.pose[:2], (x, y)))

    def end(self) -> None:
        """Ends the run after its controller has returned."""
        self.outcome = self.outcome or "returned"

    def metrics(self) -> Dict[str, Any]:
        """The measured values so far, by the names in METRICS: see docs/reference/sweeps.md."""
        found: Dict[str, Any] = dict.fromkeys(METRICS)
        found["outcome"] = self.outcome
        found["time"] = now = round(self.simulation.time, 9)  # not 2.0300000000000002
        found.update(zip(("goal_x", "goal_y"), self.goal or ()))
        if self._robot is None:
            return found
        found.update(zip(("start_x", "start_y", "start_yaw"), self._start))
        found["collision"] = bool(self._collided_with)
        found["collision_with"] = self._collided_with or None
        found["path_length"] = self._length
        found.update(motion_metrics(self._times, self._poses))
        score = self._score.row(self.outcome)
        found.update({name: score[name] for name in SCORED})
        if self._drive is None:
            found["speed_change"] = found["turn_change"] = None
        found.update(self._people.values())
        if math.isfinite(self._clearance):
            found["min_clearance"] = self._clearance
        if self.goal is not None:
            found["success"] = self._has_arrived
            if not self._has_arrived:  # a run that a collision ends early is not good at these
                found.update(dict.fromkeys(ZONES))
            if not found["person_collision"] or found["robot_at_fault"]:
                found["success_unless_hit"] = self._has_arrived
            found["timed_out"] = self.outcome == "time limit"
            found["goal_distance"] = math.dist(self._place, self.goal)
            if self._has_arrived:
                found["time_to_goal"], found["path_to_goal"] = now, self._length
            found["shortest_path"] = self._shortest
            if self._shortest is not None:
                done = self._has_arrived, self._shortest
                found["spl"] = spl(*done, self._length)
                if self._top_speed is not None:
                    found["barn_score"] = barn_score(*done, now, self._top_speed)
        return found

    def _measure(self, before: Mapping[str, Twist]) -> None:
        """Updates the metrics after a step; `before` are velocities before it, for collisions."""
        self._steps += 1
        if self._robot is not None:
            x, y, _ = self._body.pose
            self._length += math.dist(self._place, (x, y))
            self._place = (x, y)
            contacts = self.simulation.contacts
            if contacts or self._touched:
                self._note_contacts(contacts, self._robot.name, before)
            goal = None if self._collided_with else self.goal
            if goal is not None and math.dist(self._place, goal) < self.goal_radius:
                self._has_arrived = True
                self.outcome = "goal"
        if not self.outcome and self._steps >= self._limit:
            self.outcome = "time limit"

    def _note_contacts(
        self, contacts: List[Touch], robot: str, before: Mapping[str, Twist]
    ) -> None:
        """Scores the robot's contacts with bodies that are solid and not its own."""
        touched = []
        for touch in contacts:
            if touch.points and touch.model_a != touch.model_b:
                if touch.model_a == robot:
                    touched.append((touch.model_b, touch.body_b))
                elif touch.model_b == robot:
                    touched.append((touch.model_a, touch.body_a))
        self._touched = bool(touched)
        self._score.add_contacts(set(touched))
        if touched:
            self._collide(touched[0][0], before)

    def _collide(self, other: str, before: Mapping[str, Twist]) -> None:
        if not self._collided_with:
            self._collided_with = other
            self._people.note_collision(other, before)
        self._clearance = 0.0
        if self._settings.collision_ends:
            self.outcome = "collision"

    def _note_pose(self) -> None:
        """Keeps the robot's pose after a control step."""
        self.path.append(self._place)
        if self._times:
            self._people.measure(self.simulation.time - self._times[-1])
        self._times.append(self.simulation.time)
        self._poses.append(self.robot.pose)

    def _measure_clearance(self) -> None:
        """Updates the smallest distance of the robot from obstacles."""
        self._clearance = self._bodies.clearance(self._clearance)


def _drive_of(simulation: Simulation, robot: ModelHandle) -> Optional[_core.Drive]:
    """The core's drive that is commanded by a velocity, if the robot has one."""
    for plugin in simulation.world.plugins_of(robot.name).values():
        core = plugin.batch_role.drive if plugin.batch_role else None
        drive = core.drive if core else None
        if isinstance(drive, _core.Drive):
            return cast(_core.Drive, drive)
    return None
