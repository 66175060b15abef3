"""The node flatland_server: reads its parameters, loads the world and runs it."""

import gc
import logging
import math
import os
import signal
import sys
from pathlib import Path
from typing import Any, NamedTuple

import rospy

from flatland_server.exceptions import FlatlandError
from flatland_server.maps.simplify_outlines import TOLERANCES
from flatland_server.ros.clock import ClockPublisher
from flatland_server.ros.debug_visualization import FRAME_ID, DebugVisualization
from flatland_server.ros.diagnostics import Diagnostics
from flatland_server.ros.interactive_marker_manager import InteractiveMarkerManager
from flatland_server.ros.ros_transport import RosTransport
from flatland_server.ros.rospy_patches.batch_registration import batch_registration
from flatland_server.ros.rospy_patches.nonblocking_connection import use_nonblocking_connections
from flatland_server.ros.rospy_patches.tcpros_backlog import enlarge_tcpros_backlog
from flatland_server.ros.service_manager import ServiceManager
from flatland_server.ros.state_publisher import StatePublisher
from flatland_server.ros.thread_priority import ThreadPriority
from flatland_server.simulation.simulation_manager import SimulationManager
from flatland_server.simulation.world import World
from flatland_server.timekeeper import Timekeeper


class ServerConfig(NamedTuple):
    """The node's private parameters."""

    world_path: Path
    update_rate: float
    step_size: float
    show_viz: bool
    viz_pub_rate: float
    seed: int
    simplify_map: int
    realtime_priority: bool

    @classmethod
    def read(cls) -> "ServerConfig":
        """Reads and checks them.

        Raises:
            FlatlandError: one is missing or not usable.
        """
        world_path = rospy.get_param("~world_path", "")
        if not world_path:
            raise FlatlandError("the parameter ~world_path must be the path of a world file")
        seed = rospy.get_param("~seed", 0)
        if isinstance(seed, bool) or not isinstance(seed, int) or seed < 0:
            raise FlatlandError(f"~seed: expected a whole number of 0 or more, found {seed}")
        simplify_map = rospy.get_param("~simplify_map", 0)
        if isinstance(simplify_map, bool) or simplify_map not in range(len(TOLERANCES)):
            raise FlatlandError(f"~simplify_map: expected 0, 1 or 2, found {simplify_map}")
        return cls(
            world_path=Path(str(world_path)).absolute(),
            update_rate=_positive("~update_rate", 200.0, allow_infinity=True),
            step_size=_positive("~step_size", 0.005),
            show_viz=_flag("~show_viz", True),
            viz_pub_rate=_positive("~viz_pub_rate", 30.0),
            seed=seed,
            simplify_map=simplify_map,
            realtime_priority=_flag("~realtime_priority", True),
        )


def _flag(name: str, default: bool) -> bool:
    value = rospy.get_param(name, default)
    if not isinstance(value, bool):
        raise FlatlandError(f"{name}: expected true or false, found {value}")
    return value


def _positive(name: str, default: float, *, allow_infinity: bool = False) -> float:
    value: Any = rospy.get_param(name, default)
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = math.nan
    if number > 0 and (allow_infinity or math.isfinite(number)):
        return number
    raise FlatlandError(f"{name}: expected a number above 0, found {value}")


class _RosLogHandler(logging.Handler):
    """Hands what ROS-free modules and plugins log on to rosout; not what ROS logs itself."""

    def emit(self, record: logging.LogRecord) -> None:
        if record.name.startswith(("ros", "tf2_ros", "PIL")) or record.levelno < logging.INFO:
            return
        log = {"WARNING": rospy.logwarn, "ERROR": rospy.logerr, "CRITICAL": rospy.logfatal}
        log.get(record.levelname, rospy.loginfo)("%s", self.format(record))


def main() -> int:
    """Runs the node until it is shut down. Returns its exit code."""
    use_nonblocking_connections()
    rospy.init_node("flatland_server", disable_signals=True)
    logging.getLogger().addHandler(_RosLogHandler())
    enlarge_tcpros_backlog()
    try:
        _run(ServerConfig.read())
    except rospy.ROSInterruptException:
        return 0
    except FlatlandError as error:
        for line in str(error).splitlines():
            rospy.logfatal("%s", line)
        return 1
    return 0


def _run(config: ServerConfig) -> None:
    try:
        timekeeper = Timekeeper(config.step_size)
    except ValueError as error:
        raise FlatlandError(f"~step_size: {error}") from None
    transport = RosTransport()
    _end_on_signals(transport)
    with batch_registration():
        world = World.from_file(
            config.world_path, transport, seed=config.seed, simplify_map=config.simplify_map
        )
        manager = SimulationManager(world, timekeeper, config.update_rate)
        _connect(manager, transport, config)
    _spare_from_garbage_collection()
    rospy.loginfo(
        "%s: %d layers, %d models; running",
        *(config.world_path, len(world.layers), len(world.models)),
    )
    try:
        manager.run(lambda: not transport.is_ending)
    finally:
        world.close()
        rospy.signal_shutdown("the simulation has ended")


def _connect(manager: SimulationManager, transport: RosTransport, config: ServerConfig) -> None:
    """Opens the topics and services that are not a plugin's."""
    clock = ClockPublisher(manager.timekeeper)
    manager.after_step.append(clock.tick)
    manager.on_tick.append(clock.flush)
    transport.before_sending = clock.flush
    if config.show_viz:
        manager.on_tick.append(DebugVisualization(manager.world, config.viz_pub_rate).update)
        handles = InteractiveMarkerManager(manager, transport, config.viz_pub_rate, FRAME_ID)
        manager.on_tick.append(handles.update)
    manager.on_tick.append(Diagnostics(manager).update)
    manager.on_tick.append(StatePublisher(manager).update)
    if config.realtime_priority:
        manager.on_tick.append(ThreadPriority().update)
    ServiceManager(manager, transport)


def _spare_from_garbage_collection() -> None:
    """Lets the garbage collector leave alone what there is now: libraries and the loaded world.

    It would walk all of that now and again, when models are spawned above all, which holds a step
    up for longer than steps are apart. By that, a model that was loaded with the world may keep
    some memory when it is deleted; one that was spawned does not.
    """
    gc.collect()
    gc.freeze()


def _end_on_signals(transport: RosTransport) -> None:
    """Lets Ctrl-C end the simulation after the step that is under way.

    rospy's own handler shuts down on the spot, on this thread: if it interrupts a spawn that holds
    one of rospy's locks, it waits for itself for ever. While the world is loading there is no step
    to wait for, and nothing to be lost.
    """

    def end(_signal: int, _frame: Any) -> None:
        if not transport.has_started:
            os._exit(0)
        transport.end()

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, end)
    rospy.on_shutdown(transport.end)


if __name__ == "__main__":
    sys.exit(main())
