"""The node score: measures how a robot drives to the goals of its move_base.

It publishes the score of the present goal at 1 Hz of simulated time, prints a table at the end, and
appends rows to a file.
"""

import csv
import math
import sys
import threading
from collections import deque
from pathlib import Path
from typing import Any, Deque, Dict, List, Optional, Tuple

import rospy
from actionlib_msgs.msg import GoalStatus
from flatland_msgs.msg import Collisions, NavigationScore
from geometry_msgs.msg import Twist
from move_base_msgs.msg import MoveBaseActionGoal, MoveBaseActionResult
from nav_msgs.msg import Odometry

from flatland_navigation.messages import to_pose, transform_to_pose
from flatland_navigation.parameters import NodeParameters
from flatland_navigation.planner import PlanningError, plan
from flatland_navigation.robot_sensors import Transforms
from flatland_navigation.running import run_node
from flatland_navigation.score import SUCCEEDED, GoalScore, Value, table
from flatland_server import Pose, ros_time

_TF_DELAY = 0.5
"""Simulated time after which the estimate of a pose is looked up [s]."""

_OUTCOMES = {
    GoalStatus.SUCCEEDED: SUCCEEDED,
    GoalStatus.ABORTED: "aborted",
    GoalStatus.PREEMPTED: "canceled",
    GoalStatus.RECALLED: "canceled",
    GoalStatus.REJECTED: "rejected",
}


class ScoreNode:
    """Follows one robot; the ROS node must be initialised.

    Args:
        parameters: walls, robot's radius, control period and frames, as those of the navigator.
        file: of rows; None for none.
    """

    def __init__(self, parameters: NodeParameters, file: Optional[Path]) -> None:
        self._grid = parameters.read_grid()
        self._radius = parameters.navigator.robot_radius
        self._period = parameters.control_period
        self._map_frame = parameters.map_frame
        self._file = file
        self._rows: List[Dict[str, Value]] = []
        self._score: Optional[GoalScore] = None
        self._target: Optional[Pose] = None
        self._goal_id = ""
        self._truths: Deque[Tuple[Any, Pose]] = deque()
        self._next = self._next_message = self._time = -math.inf
        self._lock = threading.RLock()
        self._tf = Transforms()
        self.odometry_topic = "odometry/ground_truth"
        """The topic of the robot's true poses."""
        self._publisher = rospy.Publisher("~goal", NavigationScore, queue_size=10, latch=True)
        for topic, kind, callback in (
            (self.odometry_topic, Odometry, self._on_odometry),
            ("cmd_vel", Twist, self._on_command),
            ("collisions", Collisions, self._on_collisions),
            ("move_base/goal", MoveBaseActionGoal, self._on_goal),
            ("move_base/result", MoveBaseActionResult, self._on_result),
        ):
            rospy.Subscriber(topic, kind, self._locked(callback), queue_size=50)
        rospy.on_shutdown(self._print)

    def _locked(self, callback: Any) -> Any:
        def run(message: Any) -> None:
            with self._lock:
                callback(message)

        return run

    def _on_goal(self, message: MoveBaseActionGoal) -> None:
        self._end("canceled")  # the former goal, if there is one
        self._goal_id = message.goal_id.id
        try:
            self._target = to_pose(message.goal.target_pose.pose)
        except ValueError:
            self._target = None  # move_base will refuse it

    def _on_result(self, message: MoveBaseActionResult) -> None:
        # A goal without an id gets one by the server: then the next result is its own.
        if self._goal_id in ("", message.status.goal_id.id):
            self._end(_OUTCOMES.get(message.status.status, "lost"))

    def _on_odometry(self, message: Odometry) -> None:
        time, pose = message.header.stamp.to_sec(), to_pose(message.pose.pose)
        if time < self._time:  # a reset
            self._end("canceled")
            self._next = self._next_message = -math.inf
        self._time = time
        if time < self._next - 1e-6:
            return
        self._next = time + self._period
        if self._target is not None:
            self._begin(pose, self._target)
        if self._score is None:
            return
        self._score.add_pose(time, pose, self._grid.distance_to_wall(pose[:2]) - self._radius)
        self._truths.append((message.header.stamp, pose))
        # Transforms of the present are still on their way.
        while self._truths and time - self._truths[0][0].to_sec() >= _TF_DELAY:
            stamp, truth = self._truths.popleft()
            transform = self._tf.find(self._map_frame, message.child_frame_id, stamp)
            if transform is not None:
                estimate = transform_to_pose(transform)
                self._score.add_error(math.dist(estimate[:2], truth[:2]))
        if time >= self._next_message:
            self._next_message = time + 1.0
            self._publish(self._score.row("driving"))

    def _begin(self, start: Pose, goal: Pose) -> None:
        self._target = None
        self._truths.clear()
        try:
            path = plan(self._grid, start[:2], goal[:2]).tolist()
            shortest = sum(math.dist(a, b) for a, b in zip(path, path[1:]))
        except PlanningError:
            shortest = None
        self._score = GoalScore(len(self._rows) + 1, shortest)

    def _end(self, outcome: str) -> None:
        self._target = None
        if self._score is None:
            return
        row, self._score = self._score.row(outcome), None
        self._rows.append(row)
        self._publish(row)
        if self._file is not None:
            is_new = not self._file.exists()
            with self._file.open("a", newline="") as file:
                writer = csv.DictWriter(file, list(row), lineterminator="\n")
                if is_new:
                    writer.writeheader()
                writer.writerow(row)

    def _publish(self, row: Dict[str, Value]) -> None:
        numbers = {name: math.nan if value is None else value for name, value in row.items()}
        message = NavigationScore(**numbers)
        message.header.stamp = ros_time(round(self._time * 1e9))
        message.header.frame_id = self._map_frame
        self._publisher.publish(message)

    def _on_command(self, message: Twist) -> None:
        if self._score is not None:
            self._score.add_command(message.linear.x, message.linear.y, message.angular.z)

    def _on_collisions(self, message: Collisions) -> None:
        if self._score is not None:
            solid = (c for c in message.collisions if c.contact_positions)  # no sensors
            self._score.add_contacts({(c.entity_B, c.body_B) for c in solid})

    def _print(self) -> None:
        with self._lock:
            self._end("canceled")
            if self._rows:
                print(table(self._rows), flush=True)


def main() -> int:
    """Runs the node until it is shut down. Returns its exit code."""
    return run_node("score", _start)


def _start() -> ScoreNode:
    file = str(rospy.get_param("~file", ""))
    return ScoreNode(NodeParameters.read(), Path(file).expanduser() if file else None)


if __name__ == "__main__":
    sys.exit(main())
