"""A score of a robot's way to a goal, from its poses, commands and contacts.

Names and units are those of the columns of sweeps, so that runs with ROS and without it compare.
"""

import math
from dataclasses import dataclass, field
from typing import Dict, List, Optional, Set, Tuple, Union

from flatland_server import Pose, wrap_angle

Value = Union[int, float, bool, str, None]

SUCCEEDED = "goal"
"""The outcome of a goal that was reached."""


@dataclass
class GoalScore:
    """Measurements on the way to one goal.

    Attributes:
        goal: number of the goal, from 1.
        shortest_path: length of the shortest path from the start [m]; None if there is none.
        contacts: that have begun.
        min_clearance: of the robot to walls, so far [m].
    """

    goal: int
    shortest_path: Optional[float]
    contacts: int = 0
    min_clearance: float = math.inf
    _begin: float = 0.0
    _end: float = 0.0
    _pose: Optional[Pose] = None
    _length: float = 0.0
    _turned: float = 0.0
    _errors: List[float] = field(default_factory=list)
    _touched: Set[Tuple[str, str]] = field(default_factory=set)
    _command: Optional[Tuple[float, float, float]] = None
    _speed_change: float = 0.0
    _turn_change: float = 0.0

    def add_pose(self, time: float, pose: Pose, clearance: float) -> None:
        """Takes the true pose of a time [s], and the robot's distance to walls [m]."""
        if self._pose is None:
            self._begin = time
        else:
            self._length += math.dist(self._pose[:2], pose[:2])
            self._turned += abs(wrap_angle(pose.yaw - self._pose.yaw))
        self._end, self._pose = time, pose
        self.min_clearance = min(self.min_clearance, clearance)

    def add_command(self, vx: float, vy: float, turn: float) -> None:
        """Takes a commanded velocity [m/s, m/s] and yaw rate [rad/s]."""
        if self._command is not None:
            self._speed_change += math.dist((vx, vy), self._command[:2])
            self._turn_change += abs(turn - self._command[2])
        self._command = vx, vy, turn

    def add_contacts(self, touched: Set[Tuple[str, str]]) -> None:
        """Takes the entities and bodies that the robot touches now."""
        self.contacts += len(touched - self._touched)
        self._touched = touched

    def add_error(self, distance: float) -> None:
        """Takes a distance between the estimated and the true position [m]."""
        self._errors.append(distance)

    def row(self, outcome: str) -> Dict[str, Value]:
        """The score so far, by the names of NavigationScore.

        Args:
            outcome: "goal" if the goal was reached, another word otherwise.
        """
        success = outcome == SUCCEEDED and self.contacts == 0
        shortest, errors = self.shortest_path, self._errors
        return {
            "goal": self.goal,
            "outcome": outcome,
            "success": success,
            "time": self._end - self._begin,
            "path_length": self._length,
            "shortest_path": shortest,
            "spl": None if shortest is None else spl(success, shortest, self._length),
            "min_clearance": None if self._pose is None else self.min_clearance,
            "contacts": self.contacts,
            "localization_error": sum(errors) / len(errors) if errors else None,
            "max_localization_error": max(errors) if errors else None,
            "heading_change": self._turned,
            "speed_change": self._speed_change,
            "turn_change": self._turn_change,
        }


def spl(success: bool, shortest: float, length: float) -> float:
    """Success weighted by path length: shortest / max(length, shortest) with success, else 0.

    P. Anderson et al., "On Evaluation of Embodied Navigation Agents" (2018).

    Args:
        success: whether the run has reached its goal.
        shortest: length of the shortest path [m].
        length: of the path driven [m].
    """
    if not success:
        return 0.0
    return shortest / max(length, shortest) if shortest > 0.0 else 1.0


def table(rows: List[Dict[str, Value]]) -> str:
    """Rows as text in columns, of two decimals, the names above."""
    lines = [list(rows[0])] + [[_text(value) for value in row.values()] for row in rows]
    widths = [max(map(len, column)) for column in zip(*lines)]
    return "\n".join("  ".join(t.rjust(w) for t, w in zip(line, widths)) for line in lines)


def _text(value: Value) -> str:
    return f"{value:.2f}" if isinstance(value, float) else "" if value is None else str(value)
