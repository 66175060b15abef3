"""What a policy does with ROS messages: scans, odometry and goals in, velocities out."""

import math
from typing import Any, Optional, Tuple

import numpy as np

from flatland_gym.policy import Policy
from flatland_server import Pose, UsageError, messages

_EARLY = 0.2
"""A scan that comes so much of a period earlier than an action is due is used for it."""


class PolicyNode:
    """Commands a robot at the policy's rate, at the stamps of the scans, until it is at its goal.

    Its methods are callbacks of subscriptions to the topics of a robot.

    Args:
        policy: drives the robot.
        publisher: of geometry_msgs/Twist; anything with a method `publish`.
        goal_radius: how near to the goal the robot stops [m].
    """

    def __init__(self, policy: Policy, publisher: Any, goal_radius: float) -> None:
        if len(policy.action_limits) != 2:
            raise UsageError("expected a policy for two numbers, a speed and a yaw rate")
        self._policy = policy
        self._publisher = publisher
        self._goal_radius = goal_radius
        self._goal: Optional[Tuple[float, float]] = None
        self._state: Optional[Tuple[Pose, Tuple[float, float, float]]] = None
        self._due = -math.inf

    def on_goal(self, message: Any) -> None:
        """Takes a geometry_msgs/PoseStamped, in the frame of the odometry."""
        position = message.pose.position
        if math.isfinite(position.x) and math.isfinite(position.y):
            self._goal = (position.x, position.y)
            self._due = -math.inf

    def on_odometry(self, message: Any) -> None:
        """Takes a nav_msgs/Odometry."""
        position, q = message.pose.pose.position, message.pose.pose.orientation
        yaw = math.atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))
        twist = message.twist.twist
        velocity = (twist.linear.x, twist.linear.y, twist.angular.z)
        self._state = Pose(position.x, position.y, yaw), velocity

    def on_scan(self, message: Any) -> None:
        """Takes a sensor_msgs/LaserScan, and commands the robot if an action is due."""
        goal, state = self._goal, self._state
        stamp = message.header.stamp.to_sec()
        if goal is None or state is None or stamp < self._due:
            return
        pose, velocity = state
        self._due = stamp + (1.0 - _EARLY) * self._policy.period
        action = [0.0, 0.0]
        if math.hypot(goal[0] - pose.x, goal[1] - pose.y) < self._goal_radius:
            self._goal = None
        else:
            ranges = np.array(message.ranges, np.float32)
            action = self._policy.drive(ranges, pose, velocity, goal)
        command = messages.get("geometry_msgs/Twist")()
        command.linear.x, command.angular.z = action
        self._publisher.publish(command)
