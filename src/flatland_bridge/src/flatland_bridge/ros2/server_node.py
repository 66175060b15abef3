"""The node flatland_server of ROS 2: `ros2 run flatland_server flatland_server`.

It is the server of ROS 1 with rclpy: parameters, topics and services have the same names.
"""

import logging
import sys
from contextlib import ExitStack
from functools import partial
from typing import Any, Dict, List, Optional, Sequence

from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter

from flatland2d.cli.run import interrupts
from flatland_bridge.ros2.node import TWISTS, Ros2Node
from flatland_bridge.server import Server
from flatland_bridge.websocket_server import Access
from flatland_server.exceptions import FlatlandError, UsageError, counted, suggestion
from flatland_server.hub import ServerConfig, positive
from flatland_server.simulation import SlowPluginWatch, ThreadPriority

_DEFAULTS: Dict[str, Any] = {"static_tf": True}
"""Defaults that differ from those of ROS 1."""
_SETTABLE = ("update_rate",)
_OTHERS = ("use_sim_time", "start_type_description_service", "qos_overrides")
"""Parameters of rclpy's own, and beginnings of their names."""


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Runs the node until it is told to end.

    Args:
        arguments: of the command line; by default those of the process.

    Returns:
        The exit code: 1 if something is wrong with the parameters or the world.
    """
    with ExitStack() as stack:
        is_interrupted = stack.enter_context(interrupts())
        try:
            ros2 = Ros2Node(sys.argv[1:] if arguments is None else arguments)
        except FlatlandError as error:
            print(f"flatland_server: {error}", file=sys.stderr)
            return 1
        stack.callback(ros2.close)
        handler = _Ros2LogHandler(ros2.node)
        logging.basicConfig(
            level=logging.INFO, format="%(message)s", handlers=[handler], force=True
        )
        try:
            server = stack.enter_context(_open(ros2))
        except FlatlandError as error:
            for line in str(error).splitlines():
                ros2.node.get_logger().fatal(line)
            return 1
        server.run(lambda: not is_interrupted())
    return 0


def _open(ros2: Ros2Node) -> Server:
    parameters = Parameters(ros2.node)
    config = ServerConfig.read(parameters.get)
    ros2.command_type = parameters.get("~cmd_vel_type", "") or ros2.command_type
    if ros2.command_type not in TWISTS:
        found = ros2.command_type
        raise UsageError(f"~cmd_vel_type: expected Twist or TwistStamped, found {found}")
    page_port = parameters.get("~page_port", 0)
    if isinstance(page_port, bool) or page_port not in range(2**16):
        raise UsageError(f"~page_port: expected a port, or 0 for no page, found {page_port}")
    parameters.require_known()
    server = Server(
        config.world_path,
        seed=config.seed,
        step_size=config.step_size,
        rate=config.update_rate * config.step_size,
        params={name.replace("~", "/flatland_server/"): v for name, v in config.params.items()},
        model_folders=config.models,
        state_folder=config.state_folder,
        access=Access(),
        rosbridge_port=page_port or None,
        foxglove_port=None,
        wall_clock_stamps=config.wall_clock_stamps,
        tf_by_namespace=config.tf_by_namespace,
        ros2=ros2,
        simplify_map=config.simplify_map,
        command_age=config.command_age,
        trusts_clients=True,
        **config.hub,
    )
    manager, world = server.manager, server.manager.world
    if config.realtime_priority:
        manager.on_tick.append(ThreadPriority().update)
    manager.on_tick.append(SlowPluginWatch().update)
    ros2.node.add_on_set_parameters_callback(partial(_set_parameters, server))
    logging.getLogger(__name__).info(
        "%s: %s, %s; running in domain %d",
        config.world_path,
        counted(len(world.layers), "layer"),
        counted(len(world.models), "model"),
        ros2.domain,
    )
    return server


class Parameters:
    """The parameters of the node: declared as they are read, of any type.

    Args:
        node: the node; it has declared the parameters given on its command line.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._names: List[str] = []

    def get(self, name: str, default: Any) -> Any:
        """The value of a parameter.

        Args:
            name: such as "~seed", or a global one, which ROS 2 does not have.
            default: value if it was not given.
        """
        if not name.startswith("~"):
            return default
        name = name[1:]
        self._names.append(name)
        value = _DEFAULTS.get(name, default)
        if self._node.has_parameter(name):
            given = self._node.get_parameter(name).value
            value = value if given == "" else given  # of a launch argument that is not given
            self._node.undeclare_parameter(name)
        descriptor = ParameterDescriptor(dynamic_typing=True, read_only=name not in _SETTABLE)
        self._node.declare_parameter(name, value, descriptor, ignore_override=True)
        return value

    def require_known(self) -> None:
        """Raises a UsageError if there are parameters that were not read."""
        given = self._node.get_parameters_by_prefix("")
        for name in sorted(set(given).difference(self._names)):
            if not name.startswith(_OTHERS):
                raise UsageError(f"unknown parameter {name}{suggestion(name, self._names)}")


def _set_parameters(server: Server, parameters: Sequence[Parameter]) -> SetParametersResult:
    """Obeys a change of parameters."""
    manager = server.manager
    try:
        for each in parameters:
            if each.name == "update_rate":
                rate = positive(each.name, each.value, allow_infinity=True)
                rate *= manager.timekeeper.step_size
                server.transport.call(partial(manager.change_rate, rate))
    except (FlatlandError, ValueError) as error:
        return SetParametersResult(successful=False, reason=str(error))
    return SetParametersResult(successful=True)


class _Ros2LogHandler(logging.Handler):
    """Forwards log records to the node's logger, and so to /rosout."""

    def __init__(self, node: Node) -> None:
        super().__init__(logging.INFO)
        self._logger = node.get_logger()

    def emit(self, record: logging.LogRecord) -> None:
        if record.name.startswith("PIL"):
            return
        text = self.format(record)
        # rclpy keeps the severity of each place that logs: one place for each.
        if record.levelno >= logging.ERROR:
            self._logger.error(text)
        elif record.levelno >= logging.WARNING:
            self._logger.warning(text)
        else:
            self._logger.info(text)
