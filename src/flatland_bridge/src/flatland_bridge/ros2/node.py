"""The node of ROS 2: a client of a graph that shows it all topics and services."""

import logging
import os
import re
import threading
from functools import partial
from importlib import metadata
from itertools import groupby
from queue import SimpleQueue
from typing import Callable, Dict, List, Optional, Sequence, Set, TypeVar, Union

import rclpy
from rclpy.clock import Clock, ClockType
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from flatland_bridge import simulation_types
from flatland_bridge.budget import Budgets
from flatland_bridge.graph import NODE as GRAPH_NODE
from flatland_bridge.graph import BridgeError, Graph
from flatland_bridge.ros2.services import Services
from flatland_bridge.ros2.topics import Input, Key, Output
from flatland_bridge.ros2.types import MissingType, Types
from flatland_server.exceptions import shortened

logger = logging.getLogger(__name__)

T = TypeVar("T")

NODE = GRAPH_NODE[1:]
"""The name of the node, unless it is remapped."""

TWISTS = ("Twist", "TwistStamped")
_TWIST = "geometry_msgs/Twist"
_STAMPED_SINCE = "kilted"
"""The first distribution with a Nav2 that sends TwistStamped, if it is not told otherwise."""
_WHEELS = ("jazzy", "kilted")
"""Distributions on PyPI."""

_PERIOD = 0.2
"""Real time between two looks for new topics and subscribers [s]."""
_TOPIC = re.compile(r"(/[A-Za-z_]\w*)+", re.ASCII)


class Ros2Node:
    """A node of ROS 2. It works on a thread of its own from `serve` on, until it is closed.

    Args:
        arguments: of the command line, from `--ros-args` on.
        cmd_vel_type: the type of topics to which the simulation subscribes as Twist: "Twist" or
            "TwistStamped"; empty is what Nav2 of this distribution sends.
        only_here: whether only this machine is heard, unless the environment says otherwise.

    Attributes:
        node: rclpy's.
        distribution: of ROS 2; empty if it cannot be told.
        domain: its number, by ROS_DOMAIN_ID.
        command_type: "Twist" or "TwistStamped".

    Raises:
        BridgeError: ROS 2 does not start, such as with wrong arguments or domains.
    """

    def __init__(
        self, arguments: Sequence[str] = (), cmd_vel_type: str = "", *, only_here: bool = False
    ) -> None:
        self._context = Context()
        if only_here:
            os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        try:
            rclpy.init(
                args=list(arguments),
                context=self._context,
                signal_handler_options=SignalHandlerOptions.NO,
            )
            self.domain = self._context.get_domain_id()
            self.node = Node(
                NODE,
                context=self._context,
                automatically_declare_parameters_from_overrides=True,
            )
        except Exception as error:  # of many kinds
            self._context.try_shutdown()
            raise BridgeError(f"ROS 2 does not start: {shortened(str(error))}") from None
        self.distribution = distribution()
        self.command_type = cmd_vel_type or TWISTS[not "" < self.distribution < _STAMPED_SINCE]
        self._executor = SingleThreadedExecutor(context=self._context)
        self._thread = threading.Thread(target=self._spin, name="ros2", daemon=True)
        self._types = Types()
        self._budget = Budgets().open()  # of all that ROS 2 publishes
        self._graph: Optional[Graph] = None
        self._services: Optional[Services] = None
        self._is_ending = False
        self._lock = threading.Lock()  # of the outputs
        self._outputs: Dict[Key, Output] = {}
        # Messages are sent on a thread of their own: to wake the executor takes a millisecond.
        self._ready: SimpleQueue[Optional[Key]] = SimpleQueue()  # topics with something to send
        self._sender = threading.Thread(target=self._send, name="ros2 topics", daemon=True)
        self._inputs: Dict[Key, Input] = {}
        self._refused: Set[Key] = set()
        self._missing: Dict[str, List[str]] = {}  # topics and services to tell of, by the type
        self._told: Set[str] = set()  # missing types
        self._has_warned = False  # of another node of this name

    def serve(self, graph: Graph) -> None:
        """Shows a graph from now on."""
        self._graph = graph
        self._services = Services(self.node, graph, self._types, self._missing)
        self._follow_graph()
        # Real time: with use_sim_time, the node's own clock would stand still in a pause.
        self.node.create_timer(_PERIOD, self._update, clock=Clock(clock_type=ClockType.STEADY_TIME))
        self._executor.add_node(self.node)
        self._thread.start()
        self._sender.start()

    def close(self) -> None:
        """Leaves the graph of ROS 2 at once."""
        if self._is_ending:
            return
        self._is_ending = True
        if self._services is not None:
            self._services.close()
        if self._thread.is_alive():
            self._executor.shutdown()
            self._thread.join()
            self._ready.put(None)
            self._sender.join()
        entities: List[Union[Input, Output]] = [*self._inputs.values(), *self._outputs.values()]
        for each in entities:
            each.close()
        self.node.destroy_node()
        self._context.try_shutdown()

    # On the executor's thread

    def _spin(self) -> None:
        """Serves the node, until it is closed."""
        while not self._is_ending:
            try:
                self._executor.spin()
            except Exception as error:  # of rclpy's own services: a parameter of unknown type
                logger.error("a call by ROS 2 has failed: %s", shortened(str(error)))

    def _update(self) -> None:
        with self._lock:
            self._follow_graph()
        self._warn_of_others()

    def _follow_graph(self) -> None:
        """Opens and closes topics as they come and go."""
        assert self._graph is not None
        topics = self._graph.topics
        published = {Key(*each, each[0] in topics.latched) for each in topics.published.items()}
        gone = set(self._outputs).difference(published)
        gone.update(key for key, each in self._outputs.items() if not each.follow())
        for key in gone:
            self._outputs.pop(key).close()
        for key in sorted(published.difference(self._outputs, self._refused)):
            self._open(key, self._outputs, Output, partial(self._ready.put, key))
        subscribed = {
            Key(topic, f"geometry_msgs/{self.command_type}" if kind == _TWIST else kind)
            for topic, kind in topics.subscribed.items()
            if topic not in topics.published
        }
        for key in set(self._inputs).difference(subscribed):
            self._inputs.pop(key).close()
        for key in sorted(subscribed.difference(self._inputs, self._refused)):
            self._open(key, self._inputs, Input, self._budget)
        self._refused &= published | subscribed
        self._tell_missing()

    def _open(self, key: Key, opened: Dict[Key, T], make: Callable[..., T], end: object) -> None:
        """Opens a topic, unless ROS 2 has no such name or type."""
        try:
            if not _TOPIC.fullmatch(key.topic):
                raise BridgeError("ROS 2 allows no topic of this name")
            opened[key] = make(self.node, self._graph, key, self._types, end)
        except Exception as error:  # of any kind, from rosbags and rclpy
            self._refused.add(key)
            if isinstance(error, MissingType):
                self._missing.setdefault(str(error), []).append(key.topic)
            else:
                logger.info("%s [%s] is not a topic of ROS 2: %s", key.topic, key.kind, error)

    def _tell_missing(self) -> None:
        """Logs once which types are missing, with a line for each package."""
        new = sorted(self._missing.keys() - self._told)
        self._told.update(new)
        for package, kinds in groupby(new, lambda kind: kind.partition("/")[0]):
            names = [name for kind in kinds for name in self._missing[kind]]
            # Hardly any ROS 2 has this one, and its services are beside Flatland's own.
            level = logging.INFO if package == simulation_types.PACKAGE else logging.WARNING
            logger.log(
                level,
                "ROS 2 has no package %s, or another version, so %s left out, such as %s "
                "(docs/ros2.md)",
                *(package, "1 name is" if len(names) == 1 else f"{len(names)} names are", names[0]),
            )
        self._missing.clear()

    def _warn_of_others(self) -> None:
        """Warns once if there is another node of this name."""
        own = self.node.get_name(), self.node.get_namespace()
        if not self._has_warned and self.node.get_node_names_and_namespaces().count(own) > 1:
            self._has_warned = True
            logger.warning(
                "there is another node %s in domain %d: both publish the same topics, and calls of "
                "services may reach either; end one, or set ROS_DOMAIN_ID",
                *(self.node.get_fully_qualified_name(), self.domain),
            )

    # On a thread of its own

    def _send(self) -> None:
        """Sends messages, until the node is closed."""
        for key in iter(self._ready.get, None):
            with self._lock:
                try:
                    if key in self._outputs:
                        self._outputs[key].send()
                except Exception:  # of a message that has other fields than its type, for one
                    self._refused.add(key)
                    self._outputs.pop(key).close()
                    logger.exception("%s is no longer a topic of ROS 2", key.topic)


def distribution() -> str:
    """The name of the distribution: of the sourced one, else of the wheels; "" if neither."""
    if os.environ.get("ROS_VERSION") == "2" and "ROS_DISTRO" in os.environ:
        return os.environ["ROS_DISTRO"]
    for name in _WHEELS:
        try:
            metadata.version(f"ros-{name}-rclpy")
        except metadata.PackageNotFoundError:
            continue
        return name
    return ""
