"""The node teleop_keyboard: drives a robot with the keys of a terminal."""

import argparse
import math
import signal
import sys
import threading
import time
import xmlrpc.client
from itertools import zip_longest
from typing import Any, List

import rosgraph
import rospy
from geometry_msgs.msg import Twist

from flatland_teleop.command_publisher import command_publisher
from flatland_teleop.driving import Driving
from flatland_teleop.driving_keys import HELP, Command
from flatland_teleop.keys import KeyDecoder, KeyEvent
from flatland_teleop.robots import RobotTopic, next_topic, robot_topics
from flatland_teleop.terminal import Terminal

_PERIOD = 0.05  # s: between commands while a key is held
_POLL_PERIOD = 1.0  # s: between questions to the master

_COMMANDS = (
    ("space", "stop"),
    ("+ -", "faster, slower"),
    (". ,", "turn faster, slower"),
    ("Tab", "the next robot"),
    ("Ctrl-C", "quit"),
)


def help_lines() -> List[str]:
    """The keys and what they do, in two columns."""
    driving, commands = (
        [f"  {key:{width}}{text}" for key, text in rows]
        for rows, width in ((HELP, 16), (_COMMANDS, 8))
    )
    left_width = max(map(len, driving))
    return [
        f"{left:{left_width}}{right}".rstrip()
        for left, right in zip_longest(driving, commands, fillvalue="")
    ]


_KEYS = help_lines()


class TeleopKeyboard:
    """Publishes commands for one robot at a time, while keys are held, and one zero after that.

    Args:
        topic: of the first robot; any robot's if it is empty.
        driving: the meaning of the keys.
    """

    def __init__(self, topic: str, driving: Driving) -> None:
        self._driving = driving
        self._decoder = KeyDecoder()
        self._topics = _ask_master()
        self._topic = topic or next_topic(self._topics, rospy.resolve_name("cmd_vel"))
        self._publisher = command_publisher(self._topic)
        self._is_moving = False
        self._is_ended = False

    def run(self, terminal: Terminal) -> None:
        """Runs until the user quits, or the node is shut down."""
        rospy.on_shutdown(self._halt)  # as by rosnode kill
        threading.Thread(target=self._poll, name="topics", daemon=True).start()
        try:
            while not self._is_ended and not rospy.is_shutdown():
                terminal.show(self._lines())
                self._step(terminal.read(_PERIOD))
        finally:
            self._is_ended = True
            self._halt()

    def end(self) -> None:
        """Makes `run` end soon. May be called by a handler of signals."""
        self._is_ended = True

    def _poll(self) -> None:
        while not self._is_ended:
            self._topics = _ask_master()
            time.sleep(_POLL_PERIOD)

    def _step(self, typed: Any) -> None:
        if typed is None:
            self._is_ended = True
            return
        for event in self._decoder.decode(typed):
            self._on_key(event)
        command = self._driving.command(time.monotonic())
        if command != Command():
            self._publish(command)
        elif self._is_moving:
            self._halt()

    def _on_key(self, event: KeyEvent) -> None:
        if event.key == "quit":
            self._is_ended = True
        elif event.key == "tab" and not event.is_release:
            self._choose(next_topic(self._topics, self._topic))
        else:
            self._driving.on_key(event, time.monotonic())

    def _choose(self, topic: str) -> None:
        if topic == self._topic:
            return
        self._halt()
        self._publisher.unregister()
        self._topic = topic
        self._publisher = command_publisher(topic)

    def _publish(self, command: Command) -> None:
        message = Twist()
        message.linear.x, message.linear.y, message.angular.z = command
        try:
            self._publisher.publish(message)
        except rospy.ROSException:  # the node is being shut down
            return
        self._is_moving = command != Command()

    def _halt(self) -> None:
        """Stops the robot by one message; other nodes may drive it after that."""
        self._driving.stop()
        if self._is_moving:
            self._publish(Command())

    def _lines(self) -> List[str]:
        command = self._driving.command(time.monotonic())
        here = [topic for topic in self._topics if topic.name == self._topic]
        count = len({self._topic, *(topic.name for topic in self._topics)})
        state = f"  {self._topic}" + (f"   (Tab: {count - 1} more)" if count > 1 else "")
        if not here:
            state += "   no robot subscribes to it"
        elif here[0].publishers:
            state += f"   {', '.join(here[0].publishers)} also publishes on it"
        return [
            *_KEYS,
            "",
            state,
            f"  speed {self._driving.speed:.2f} m/s, turning {self._driving.turn:.2f} rad/s"
            f"   now {command.x:+.2f} {command.y:+.2f} m/s, {command.yaw:+.2f} rad/s",
        ]


def _ask_master() -> List[RobotTopic]:
    master = rosgraph.Master(rospy.get_name())
    try:
        return robot_topics(master.getSystemState(), master.getTopicTypes(), rospy.get_name())
    except (OSError, xmlrpc.client.Error, rosgraph.MasterException):
        return []  # there is no master now


def _positive(name: str, default: float) -> float:
    """A private parameter, a number above zero.

    Raises:
        ValueError: it is something else.
    """
    value: Any = rospy.get_param(f"~{name}", default)
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if is_number and math.isfinite(value) and value > 0.0:
        return float(value)
    raise ValueError(f"~{name}: expected a number above 0, found {value!r}")


def main() -> int:
    """Drives until Ctrl-C. Returns the exit code: 2 for wrong arguments, 1 without a terminal."""
    parser = argparse.ArgumentParser(
        prog="teleop_keyboard",
        description="Drives a robot with the keys of this terminal.",
        epilog="Parameters: ~speed [m/s], ~turn [rad/s], ~first_timeout and ~repeat_timeout [s]: "
        "how long a key counts as held, where the terminal does not tell of its release.",
    )
    parser.add_argument(
        "namespace", nargs="?", default="", help="of the robot, as robot1; none for /cmd_vel"
    )
    options = parser.parse_args(rospy.myargv()[1:])
    if options.namespace and not rosgraph.names.is_legal_name(options.namespace):
        parser.error(f"expected a namespace, as robot1, found {options.namespace!r}")
    try:
        terminal = Terminal()
    except OSError:
        print(
            "teleop_keyboard reads the keys of a terminal, and this is none. In a launch file, "
            'give it one of its own: <node ... launch-prefix="xterm -e"/>',
            file=sys.stderr,
        )
        return 1
    # rospy's own handlers would close the connections while the robot still drives.
    rospy.init_node("teleop_keyboard", anonymous=True, disable_signals=True)
    try:
        driving = Driving(
            *(
                _positive(name, default)
                for name, default in (
                    ("speed", 0.5),
                    ("turn", 1.0),
                    ("first_timeout", 0.7),
                    ("repeat_timeout", 0.2),
                )
            )
        )
    except ValueError as error:
        print(error, file=sys.stderr)
        return 2
    topic = rospy.resolve_name(rosgraph.names.ns_join(options.namespace, "cmd_vel"))
    is_chosen = bool(options.namespace) or topic != "/cmd_vel"
    teleop = TeleopKeyboard(topic if is_chosen else "", driving)
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda *_: teleop.end())
    with terminal:
        teleop.run(terminal)
    rospy.signal_shutdown("quit")
    return 0
