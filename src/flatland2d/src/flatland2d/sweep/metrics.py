"""The metrics of runs: names, units, formulas, and which change is for the better."""

import math
from typing import Dict, NamedTuple, Optional, Sequence

import numpy as np

from flatland_server.geometry import Pose

_STANDING = 0.01  # m/s, and rad/s


class Metric(NamedTuple):
    """A measured value that is summarised and compared.

    Attributes:
        label: as in tables and figures, with its unit.
        better: 1 if larger values are better, -1 if smaller ones are, 0 if neither.
        most: the largest value that there can be; the least one is 0. Intervals end there.
        is_rate: whether each run has true or false.
        is_gated: whether a change for the worse is a regression.
    """

    label: str
    better: int
    most: float = math.inf
    is_rate: bool = False
    is_gated: bool = False


METRICS: Dict[str, Optional[Metric]] = {
    "outcome": None,
    "success": Metric("success", 1, is_rate=True, is_gated=True),
    "collision": Metric("collision", -1, is_rate=True, is_gated=True),
    "collision_with": None,
    "contacts": None,
    "person_collision": Metric("collision with a person", -1, is_rate=True),
    "robot_at_fault": Metric("at-fault collision with a person", -1, is_rate=True),
    "success_unless_hit": Metric("success unless hit by a person", 1, is_rate=True),
    "robot_speed_at_contact": None,
    "person_speed_at_contact": None,
    "timed_out": Metric("time-out", -1, is_rate=True),
    "time": None,
    "time_to_goal": Metric("time to goal [s]", -1, is_gated=True),
    "path_to_goal": Metric("path to goal [m]", -1),
    "path_length": None,
    "shortest_path": None,
    "spl": Metric("SPL", 1, 1.0),
    "barn_score": Metric("BARN score", 1, 0.5),
    "min_clearance": Metric("least clearance [m]", 1),
    "people_distance": Metric("least distance from people [m]", 1),
    "mean_people_distance": Metric("mean distance from people [m]", 1),
    "intimate_fraction": Metric("fraction of time in intimate space", -1, 1.0),
    "personal_fraction": Metric("fraction of time in personal space", -1, 1.0),
    "social_fraction": Metric("fraction of time in social space", 0, 1.0),
    "group_crossing_rate": Metric("group crossing rate", -1, 1.0),
    "stalled_time": Metric("stalled time [s]", -1),
    "heading_change": Metric("heading change [rad]", -1),
    "mean_jerk": Metric("mean jerk [m/s³]", -1),
    "speed_change": Metric("change of commanded speed [m/s]", -1),
    "turn_change": Metric("change of commanded yaw rate [rad/s]", -1),
    "localization_error": Metric("localisation error [m]", -1),
    "max_localization_error": None,
    "goal_distance": None,
    "start_x": None,
    "start_y": None,
    "start_yaw": None,
    "goal_x": None,
    "goal_y": None,
}
"""The measured values of each scenario, in the order of the table's columns; None: it is neither
summarised nor compared.
"""

SUMMARISED = {name: metric for name, metric in METRICS.items() if metric is not None}
"""The metrics that are summarised, by the names of their columns."""


def barn_score(success: bool, shortest: float, time: float, top_speed: float) -> float:
    """T / clip(time, 2 T, 8 T) with success, else 0; T is the time of the path at top speed.

    The metric of the BARN Challenge (X. Xiao et al., "Autonomous Ground Navigation in Highly
    Constrained Spaces", 2022), with the factors of its run.py of 2026: at most 0.5.

    Args:
        success: whether the run has reached its goal.
        shortest: length of the shortest path [m], above 0.
        time: until the goal was reached [s].
        top_speed: of the robot [m/s]; 2 in the challenge.
    """
    best = shortest / top_speed
    return best / min(max(time, 2.0 * best), 8.0 * best) if success and best > 0.0 else 0.0


def motion_metrics(times: Sequence[float], poses: Sequence[Pose]) -> Dict[str, Optional[float]]:
    """Measures of steady driving, from the poses of a robot at control steps.

    - `stalled_time`: the time of control steps in which it moved by less than 0.01 m/s and turned
      by less than 0.01 rad/s.
    - `heading_change`: the sum of |yaw[k+1] - yaw[k]|, each wrapped to pi at most.
    - `mean_jerk`: the mean of |p[k+3] - 3 p[k+2] + 3 p[k+1] - p[k]| / dt^3, over four poses at
      equal intervals dt.

    A. Francis et al., "Principles and Guidelines for Evaluating Social Robot Navigation Algorithms"
    (2023); N. Perez-Higueras et al., "HuNavSim" (2023).

    Args:
        times: the poses' times [s].
        poses: poses of the robot [m, m, rad], one more than control steps.
    """
    t, (x, y, yaw) = np.asarray(times), np.array(poses).reshape(-1, 3).T
    dt = np.diff(t)
    turns = np.abs((np.diff(yaw) + math.pi) % math.tau - math.pi)
    stands = (np.hypot(np.diff(x), np.diff(y)) < _STANDING * dt) & (turns < _STANDING * dt)
    even = np.isclose(dt[1:], dt[:-1])
    even = even[1:] & even[:-1]
    jerks = np.hypot(np.diff(x, 3), np.diff(y, 3))[even] / dt[2:][even] ** 3
    return {
        "stalled_time": float(dt[stands].sum()),
        "heading_change": float(turns.sum()),
        "mean_jerk": float(jerks.mean()) if len(jerks) else None,
    }
