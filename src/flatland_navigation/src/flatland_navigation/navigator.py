"""Drives a robot to goals: plans, follows, stops before obstacles, plans around them, gives up.

A `Navigator` takes poses, scans and goals, and returns a command for each pose. It uses neither ROS
nor a clock: its time is that of the poses.
"""

import enum
import math
from dataclasses import dataclass, field
from typing import Optional

import numpy as np

from flatland_navigation.follower import Command, FollowerConfig, PathFollower
from flatland_navigation.grid import Grid
from flatland_navigation.obstacles import free_distance, safe_speed, to_frame
from flatland_navigation.planner import PlanningError, plan
from flatland_server import FloatArray, Pose

_NO_POINTS: FloatArray = np.empty((0, 2))
_CRAWL = 0.02  # m/s; slower is blocked
_MOVED = 0.2  # m; less is no progress
_NEAR = 0.1  # m; a nearer obstacle counts as the one that stops the robot
_TOO_FAST = "poses and scans come too rarely"  # for the rate of simulated time


class Status(enum.Enum):
    """The state of the last goal."""

    IDLE = enum.auto()
    ACTIVE = enum.auto()
    SUCCEEDED = enum.auto()
    ABORTED = enum.auto()


@dataclass(frozen=True)
class NavigatorConfig:
    """Distances and times at which a robot stops, replans and gives up.

    Attributes:
        robot_radius: [m].
        stop_margin: distance to obstacles at which the robot stands still [m].
        replan_after: waiting time before an obstacle until a way around it is planned [s].
        stuck_after: time without progress after which a goal is given up [s].
        max_replans: number of plans around obstacles for one goal.
        follower: speeds and tolerances.
    """

    robot_radius: float = 0.18
    stop_margin: float = 0.05
    replan_after: float = 1.0
    stuck_after: float = 10.0
    max_replans: int = 20
    follower: FollowerConfig = field(default_factory=FollowerConfig)


class Navigator:
    """Drives one robot; all positions are in the frame of the grid.

    Args:
        grid: free cells for the robot's centre.
        config: radius, speeds, time limits.
    """

    def __init__(self, grid: Grid, config: NavigatorConfig) -> None:
        self.status = Status.IDLE
        self.text = ""
        """The reason for the status."""
        self.path: FloatArray = _NO_POINTS
        """The path to the goal [m], shape (n, 2); empty without an active goal."""
        self._grid = grid
        self._config = config
        self._goal: Optional[Pose] = None
        self._follower: Optional[PathFollower] = None
        self._points = _NO_POINTS
        self._scan_time = -math.inf
        self._time = -math.inf  # of the last pose
        self._blocked_since: Optional[float] = None
        self._checkpoint = Pose()
        self._checkpoint_time = -math.inf
        self._replans = 0
        self._hindrance = ""

    def set_goal(self, goal: Pose) -> None:
        """Replaces the goal; the next pose is the start."""
        self._goal, self._follower = goal, None
        self._replans = 0
        self._blocked_since = None
        self.path = _NO_POINTS
        self.status, self.text = Status.ACTIVE, ""

    def cancel(self) -> None:
        """Gives up the goal, if there is one."""
        self._end(Status.IDLE, "canceled")

    def observe(self, points: FloatArray, time: float) -> None:
        """Takes a laser scan.

        Args:
            points: that the beams hit [m]: shape (n, 2).
            time: the scan's time [s].
        """
        self._points, self._scan_time = points, time

    def update(self, pose: Pose, time: float) -> Command:
        """The command for a robot at a pose.

        Args:
            pose: pose of the robot in the frame of the grid [m, m, rad].
            time: of the pose [s]; if it lies before that of the last pose, simulated time has
                gone back, and scans are dropped.
        """
        period = time - self._time
        self._time = time
        if period < 0.0:
            self._points, self._scan_time = _NO_POINTS, -math.inf
            self._checkpoint_time = time
            self._blocked_since = None
        if self._goal is None:
            return Command()
        if self._follower is None:
            self._start(pose, self._goal)
        if self._follower is None:
            return Command()
        period = period if 0.0 < period < math.inf else 0.1
        wanted = self._follower.command(pose, period)
        if self._follower.is_done(pose):
            self._end(Status.SUCCEEDED, "the goal is reached")
            return Command()
        command = self._before_obstacles(wanted, pose, period)
        self._note_progress(pose)
        if self._goal is not None and self._is_blocked(command, wanted):
            self._replan(pose, self._goal)
        return command if self.status is Status.ACTIVE else Command()

    def _start(self, pose: Pose, goal: Pose) -> None:
        try:
            self._follow(plan(self._grid, (pose.x, pose.y), (goal.x, goal.y)), self._grid, goal)
        except PlanningError as error:
            self._end(Status.ABORTED, str(error))
        self._checkpoint, self._checkpoint_time = pose, self._time

    def _follow(self, path: FloatArray, grid: Grid, goal: Pose) -> None:
        self.path = path
        self._follower = PathFollower(path, goal.yaw, self._config.follower, grid.line_is_free)

    def _end(self, status: Status, text: str) -> None:
        if self._goal is not None:
            self.status, self.text = status, text
        self._goal = self._follower = None
        self.path = _NO_POINTS

    def _before_obstacles(self, command: Command, pose: Pose, period: float) -> Command:
        """The command, slowed down so that the robot can stop before obstacles."""
        self._hindrance = "it does not move"
        if command.forwards <= 0.0 or len(self._points) == 0:
            return command
        deceleration = self._config.follower.deceleration
        delay = period + max(self._time - self._scan_time, 0.0)
        limit = command.forwards * delay + command.forwards**2 / (2.0 * deceleration) + 0.05
        distance = free_distance(
            to_frame(self._points, pose),
            command.turn / command.forwards,
            self._config.robot_radius + self._config.stop_margin,
            limit,
        )
        speed = min(command.forwards, safe_speed(distance, deceleration, delay))
        if speed < _CRAWL:
            is_near = distance < _NEAR
            self._hindrance = "an obstacle is in its way" if is_near else _TOO_FAST
            return Command()
        return Command(speed, command.turn * speed / command.forwards)

    def _is_blocked(self, command: Command, wanted: Command) -> bool:
        """True if the robot has stood before an obstacle for some time."""
        if wanted.forwards < _CRAWL or command.forwards >= _CRAWL:
            self._blocked_since = None
            return False
        if self._blocked_since is None:
            self._blocked_since = self._time
        return self._time - self._blocked_since >= self._config.replan_after

    def _replan(self, pose: Pose, goal: Pose) -> None:
        """Plans a way around obstacles in the scan; without one, the robot goes on waiting."""
        self._blocked_since = None
        if self._replans == self._config.max_replans:
            self._end(Status.ABORTED, f"stuck: blocked {self._replans + 1} times on the way")
            return
        self._replans += 1
        grid = self._grid.with_obstacles(self._points)
        try:
            self._follow(plan(grid, (pose.x, pose.y), (goal.x, goal.y)), grid, goal)
        except PlanningError:
            return

    def _note_progress(self, pose: Pose) -> None:
        moved = math.hypot(pose.x - self._checkpoint.x, pose.y - self._checkpoint.y) >= _MOVED
        if moved:
            self._checkpoint, self._checkpoint_time = pose, self._time
        elif self._time - self._checkpoint_time >= self._config.stuck_after:
            self._end(
                Status.ABORTED,
                f"stuck at ({pose.x:.2f}, {pose.y:.2f}): no progress for "
                f"{self._config.stuck_after:g} s, {self._hindrance}",
            )
