"""A policy on ROS messages: scans, odometry and goals in, velocities out."""

import math
import threading
from typing import Any, Callable, Optional, Tuple

import numpy as np

from flatland2d import Pose, UsageError, messages
from flatland_gym.policy import Policy
from flatland_server import yaw_of

_EARLY = 0.2
"""A scan is used for an action that is due at most this fraction of a period later."""


class PolicyNode:
    """Commands a robot at the policy's rate, at the stamps of the scans, until it is at its goal.

    Its methods are callbacks of subscriptions to the topics of a robot, in any thread.

    Args:
        policy: policy that drives the robot.
        publisher: of geometry_msgs/Twist; anything with a method `publish`.
        goal_radius: how near to the goal the robot stops [m].
        report: called with what makes the policy give up a goal, such as `rospy.logerr`.

    Raises:
        UsageError: the policy has other actions than a speed and a yaw rate, or neighbours.
    """

    def __init__(
        self,
        policy: Policy,
        publisher: Any,
        goal_radius: float,
        report: Callable[[str], None] = lambda _: None,
    ) -> None:
        if len(policy.action_limits) != 2:
            raise UsageError("expected a policy for two numbers, a speed and a yaw rate")
        if policy.neighbors:
            raise UsageError(
                "expected a policy that drives by its lidar alone, found one with "
                f"neighbors={policy.neighbors}: no topic has the motions of other models"
            )
        self._policy = policy
        self._publisher = publisher
        self._goal_radius = goal_radius
        self._report = report
        self._lock = threading.Lock()
        self._goal: Optional[Tuple[float, float]] = None
        self._state: Optional[Tuple[Pose, Tuple[float, float, float]]] = None
        self._last = -math.inf  # stamp of the last scan [s]
        self._due = -math.inf

    def on_goal(self, message: Any) -> None:
        """Takes a geometry_msgs/PoseStamped, in the frame of the odometry."""
        position = message.pose.position
        if not (math.isfinite(position.x) and math.isfinite(position.y)):
            self._report(f"expected a finite goal, found ({position.x}, {position.y})")
            return
        with self._lock:
            self._goal = (position.x, position.y)
            self._due = -math.inf

    def on_odometry(self, message: Any) -> None:
        """Takes a nav_msgs/Odometry."""
        position = message.pose.pose.position
        pose = Pose(position.x, position.y, yaw_of(message.pose.pose.orientation))
        twist = message.twist.twist
        with self._lock:
            self._state = pose, (twist.linear.x, twist.linear.y, twist.angular.z)

    def on_scan(self, message: Any) -> None:
        """Takes a sensor_msgs/LaserScan, and commands the robot if an action is due."""
        stamp = message.header.stamp.to_sec()
        with self._lock:
            if stamp < self._last:  # the world was reset
                self._due = -math.inf
            self._last = stamp
            if self._goal is None or self._state is None or stamp < self._due:
                return
            self._due = stamp + (1.0 - _EARLY) * self._policy.period
            speed, turn = self._act(message.ranges, self._goal, *self._state)
        command = messages.get("geometry_msgs/Twist")()
        command.linear.x, command.angular.z = speed, turn
        self._publisher.publish(command)

    def _act(
        self,
        ranges: Any,
        goal: Tuple[float, float],
        pose: Pose,
        velocity: Tuple[float, float, float],
    ) -> Tuple[float, float]:
        """The speed and the yaw rate. At the goal both are zero, and the goal is dropped."""
        beams = self._policy.beams
        if not all(map(math.isfinite, (*pose, *velocity))):
            self._report(f"expected finite odometry, found {tuple(pose)} and {velocity}")
        elif len(ranges) != beams:
            self._report(
                f"expected scans of {beams} ranges, for which the policy was trained, found "
                f"{len(ranges)}"
            )
        elif math.hypot(goal[0] - pose.x, goal[1] - pose.y) >= self._goal_radius:
            action = self._policy.drive(np.array(ranges, np.float32), pose, velocity, goal)
            return action[0], action[1]
        self._goal = None
        return 0.0, 0.0
