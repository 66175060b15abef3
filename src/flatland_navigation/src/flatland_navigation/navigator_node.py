"""The node navigator: drives a robot to goals, with the topics and the action of move_base.

All work is done on the thread that receives the robot's pose; the other callbacks only store what
they receive. The node is thus driven by simulated time: it does nothing while that is paused.
"""

import math
import sys
import threading
from collections import deque
from typing import Deque, Optional, Tuple

import actionlib
import rospy
from geometry_msgs.msg import PoseStamped, Twist
from move_base_msgs.msg import (
    MoveBaseAction,
    MoveBaseActionGoal,
    MoveBaseFeedback,
    MoveBaseGoal,
    MoveBaseResult,
)
from nav_msgs.msg import Odometry, Path

from flatland_navigation.follower import Command
from flatland_navigation.messages import to_pose
from flatland_navigation.navigator import Navigator, Status
from flatland_navigation.parameters import NodeParameters
from flatland_navigation.robot_sensors import Localization, ScanReader
from flatland_navigation.running import run_node
from flatland_server import FloatArray, Pose, fill_pose

_MOST_POSES = 200
_ACTION = "move_base"
_SCAN_LIMIT = 5.0  # s of simulated time after which a missing scan is warned about


class NavigatorNode:
    """The topics of a `Navigator`; see the module.

    Raises:
        FlatlandError: the world cannot be read.
    """

    def __init__(self, parameters: NodeParameters) -> None:
        self._map_frame = parameters.map_frame
        self._period = parameters.control_period
        self._navigator = Navigator(parameters.read_grid(), parameters.navigator)
        self._poses: Deque[Tuple[float, Pose]] = deque(maxlen=_MOST_POSES)
        self._last_control = -1.0
        self._lock = threading.Lock()  # held while a pose is handled
        self._has_ended = False
        self._is_ready = False
        self._waits_since = math.inf
        self._published_path: Optional[FloatArray] = None
        self._commands = rospy.Publisher("cmd_vel", Twist, queue_size=1)
        self._plans = rospy.Publisher("~plan", Path, queue_size=1, latch=True)
        self._current_goals = rospy.Publisher(
            "~current_goal", PoseStamped, queue_size=1, latch=True
        )
        self._goals = rospy.Publisher(f"{_ACTION}/goal", MoveBaseActionGoal, queue_size=1)
        self._server = _start_server()
        self._simple_goals = rospy.Subscriber(
            "move_base_simple/goal", PoseStamped, self._on_simple_goal, queue_size=1
        )
        self._scans = ScanReader("scan")
        self._localization = Localization(
            parameters.pose_source, parameters.map_frame, parameters.odom_topic
        )
        self.odometry_topic = self._localization.topic
        """The topic of the poses that it works at."""
        self._odometry = rospy.Subscriber(
            self.odometry_topic, Odometry, self._on_odometry, queue_size=1, tcp_nodelay=True
        )
        rospy.on_shutdown(self._stop)

    def _on_simple_goal(self, message: PoseStamped) -> None:
        """Passes a goal on to the action, as move_base does."""
        goal = MoveBaseActionGoal(goal=MoveBaseGoal(target_pose=message))
        goal.header.stamp = rospy.Time.now()
        self._goals.publish(goal)

    def _on_odometry(self, message: Odometry) -> None:
        with self._lock:
            if not self._has_ended:
                self._handle(message)

    def _handle(self, message: Odometry) -> None:
        """Controls the robot, at the control rate of simulated time at most."""
        pose = self._localization.pose(message)
        if pose is None:
            return
        time = message.header.stamp.to_sec()
        if self._poses and time < self._poses[-1][0]:
            self._restart()
        self._poses.append((time, pose))
        self._note_readiness()
        self._take_goal()
        if time - self._last_control < self._period - 1e-6:
            return
        self._last_control = time
        self._take_scan(message.child_frame_id)
        if self._navigator.status is Status.ACTIVE:
            self._control(pose, time)

    def _note_readiness(self) -> None:
        """Logs once that goals are received now; earlier ones are lost silently."""
        if not self._is_ready and self._goals.get_num_connections():
            self._is_ready = True
            rospy.loginfo("ready for goals")

    def _restart(self) -> None:
        """Drops poses and goals: simulated time has gone back, as after a restart of the server."""
        self._poses.clear()
        self._last_control = -1.0
        if self._navigator.status is Status.ACTIVE:
            self._navigator.cancel()
            self._abort("simulated time has gone back")
        # The action server refuses goals with earlier stamps than the latest one.
        with self._server.action_server.lock, self._server.lock:
            if not self._server.is_new_goal_available():
                self._server.current_goal = actionlib.ServerGoalHandle()
                self._server.next_goal = actionlib.ServerGoalHandle()

    def _take_goal(self) -> None:
        """Starts a new goal or cancels the present one, as the action's client asks."""
        if self._server.is_new_goal_available():
            goal = self._server.accept_new_goal()
            target = goal.target_pose
            try:
                frame = target.header.frame_id.lstrip("/")
                if frame not in ("", self._map_frame):
                    raise ValueError(
                        f'expected a goal in the frame "{self._map_frame}", found "{frame}"'
                    )
                self._navigator.set_goal(to_pose(target.pose))
                target.header.frame_id = self._map_frame
                self._current_goals.publish(target)
            except ValueError as error:
                self._navigator.cancel()
                self._abort(str(error))
        if self._server.is_active() and self._server.is_preempt_requested():
            self._navigator.cancel()
            self._publish_plan()
            self._send(Command())
            self._server.set_preempted(MoveBaseResult(), "the goal was canceled")

    def _take_scan(self, base_frame: str) -> None:
        scan = self._scans.take(base_frame)
        if scan is not None:
            # The robot's pose when it scanned.
            _, pose = min(self._poses, key=lambda each: abs(each[0] - scan.time))
            self._navigator.observe(scan.points_from(pose), scan.time)

    def _control(self, pose: Pose, time: float) -> None:
        if self._scans.is_awaited:
            self._waits_since = min(self._waits_since, time)
            if time - self._waits_since > _SCAN_LIMIT:
                rospy.logwarn_throttle(10.0, "waiting for a scan and for the laser's transform")
            return
        if not self._scans.has_laser:
            rospy.loginfo_once(f"{self._scans.topic} has no publisher: driving by the map alone")
        command = self._navigator.update(pose, time)
        self._send(command)
        self._publish_plan()
        if self._navigator.status is Status.ACTIVE:
            feedback = MoveBaseFeedback()
            feedback.base_position.header.frame_id = self._map_frame
            feedback.base_position.header.stamp = rospy.Time.from_sec(time)
            fill_pose(feedback.base_position.pose, pose)
            self._server.publish_feedback(feedback)
        elif self._navigator.status is Status.SUCCEEDED:
            rospy.loginfo("%s", self._navigator.text)
            self._server.set_succeeded(MoveBaseResult(), self._navigator.text)
        else:
            self._abort(self._navigator.text)

    def _abort(self, reason: str) -> None:
        rospy.logwarn("%s", reason)
        self._send(Command())
        self._publish_plan()
        self._server.set_aborted(MoveBaseResult(), reason)

    def _send(self, command: Command) -> None:
        twist = Twist()
        twist.linear.x, twist.angular.z = command
        self._commands.publish(twist)

    def _publish_plan(self) -> None:
        """Publishes the path after it has changed."""
        path = self._navigator.path
        if path is self._published_path:
            return
        self._published_path = path
        message = Path()
        message.header.frame_id = self._map_frame
        message.header.stamp = rospy.Time.now()
        for x, y in path:
            pose = PoseStamped(header=message.header)
            fill_pose(pose.pose, Pose(float(x), float(y)))
            message.poses.append(pose)
        self._plans.publish(message)

    def _stop(self) -> None:
        """Stops the robot, with the last command of the node."""
        with self._lock:
            self._has_ended = True
            if self._navigator.status is Status.ACTIVE:
                self._send(Command())


def _start_server() -> actionlib.SimpleActionServer:
    """Starts the action server; its status is published also after simulated time has gone back."""
    server = actionlib.SimpleActionServer(_ACTION, MoveBaseAction, auto_start=False)
    server.start()
    actions = server.action_server
    if actions.status_frequency > 0.0:
        actions.status_timer.shutdown()  # it would end with an exception
        actions.status_timer = rospy.Timer(
            rospy.Duration(1.0 / actions.status_frequency), actions.publish_status_async, reset=True
        )

    def stop_status() -> None:
        with actions.lock:  # first, the timer ends what it is publishing
            actions.started = False

    rospy.on_shutdown(stop_status)  # rospy closes the topics after this
    return server


def main() -> int:
    """Runs the node until it is shut down. Returns its exit code."""
    return run_node("move_base", lambda: NavigatorNode(NodeParameters.read()))


if __name__ == "__main__":
    sys.exit(main())
