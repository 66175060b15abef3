"""The node flatland_server: loads a world, opens its topics and services, and runs it.

The node flatland_benchmark does the same, and ends after some simulated time.
"""

import atexit
import gc
import logging
import resource
from functools import partial
from typing import Any, Callable, Optional

import rosgraph
import rospy

from flatland_server.exceptions import FlatlandError, counted
from flatland_server.hub.assembly import open_hub
from flatland_server.hub.client_files import ClientFiles
from flatland_server.hub.hub import Hub, Service, ServiceError
from flatland_server.hub.recent_log import RecentLog
from flatland_server.hub.server_config import ServerConfig
from flatland_server.ros import other_nodes, rospy_patches
from flatland_server.ros.clock import warn_of_other_times
from flatland_server.ros.launch_arguments import check_launch_arguments, parent_command_line
from flatland_server.ros.log_handler import LoadingPublisher, RosLogHandler, tolerate_write_errors
from flatland_server.ros.node import open_closed_streams
from flatland_server.ros.ros_transport import RosTransport
from flatland_server.ros.rospy_patches.master_calls import NO_ANSWER, Master
from flatland_server.ros.server_parameters import RosConfig, read_config
from flatland_server.ros.shutdown import Shutdown
from flatland_server.simulation.pacer import WallTimekeeper
from flatland_server.simulation.simulation_manager import SimulationManager
from flatland_server.simulation.slow_plugin_watch import SlowPluginWatch
from flatland_server.simulation.thread_priority import ThreadPriority
from flatland_server.simulation.world import World
from flatland_server.timekeeper import Timekeeper

_REGISTRATION_LIMIT = 10.0
"""Real time that the ROS master has to register the topics of the world [s]."""

_ENOUGH_FILES, _FEW_FILES = 65536, 4096
"""Open files to ask for, where the usual soft limit is 1,024; and with fewer there is a warning."""

logger = logging.getLogger(__name__)

Simulate = Callable[[SimulationManager, Callable[[], bool]], None]
"""Runs a simulation while the second argument returns true."""


def main() -> int:
    """Runs the node until it is shut down. Returns its exit code."""
    return run_node("flatland_server", SimulationManager.run)


def run_node(name: str, simulate: Simulate) -> int:
    """Runs a node with the parameters, topics and services of flatland_server.

    Args:
        name: of the node.
        simulate: runs the simulation. The node ends when it returns.

    Returns:
        The exit code.
    """
    atexit.register(gc.freeze)  # no garbage collection at exit, to save time
    open_closed_streams()
    rospy.init_node(name, disable_signals=True)
    logging.getLogger().addHandler(RosLogHandler())
    log = RecentLog(logging.getLogger("rosout"))
    tolerate_write_errors()
    _raise_file_limit()
    try:
        config = read_config()
        if config.launch_file is not None:
            check_launch_arguments([config.launch_file], parent_command_line())
        _run(config, simulate, log)
    except rospy.ROSInterruptException:
        return 0
    except FlatlandError as error:
        for line in str(error).splitlines():
            rospy.logfatal("%s", line)
        return 1
    return 0


def _run(ros_config: RosConfig, simulate: Simulate, log: RecentLog) -> None:
    config = ros_config.server
    try:
        timekeeper = (WallTimekeeper if config.wall_clock_stamps else Timekeeper)(config.step_size)
    except ValueError as error:
        raise FlatlandError(f"~step_size: {error}") from None
    shutdown = Shutdown()
    patches = rospy_patches.PATCHES if ros_config.rospy_patches else ()
    transport = RosTransport(rospy_patches.install(patches), config.params)
    transport.tf_by_namespace = config.tf_by_namespace
    shutdown.transport = transport
    LoadingPublisher()
    with transport.rospy_calls.batch_registration():
        world = World.from_file(
            config.world_path,
            transport,
            seed=config.seed,
            simplify_map=config.simplify_map,
            model_folders=config.models,
        )
        manager = SimulationManager(
            world, timekeeper, config.update_rate, command_age=config.command_age
        )
        localisers = _open_hub(manager, config, log)
    exclude_from_garbage_collection()
    if transport.rospy_calls.wait_until_registered(_REGISTRATION_LIMIT):
        if not config.wall_clock_stamps:
            warn_of_other_times()  # of two nodes that start together, the second sees the first
    else:
        rospy.logwarn("the simulation starts before the ROS master knows all of its topics")
    other_nodes.watch(transport.publisher_counts, localisers)
    rospy.loginfo(
        "%s: %s, %s; running",
        config.world_path,
        counted(len(world.layers), "layer"),
        counted(len(world.models), "model"),
    )
    try:
        simulate(manager, lambda: not transport.is_ending)
    finally:
        shutdown.steps_have_ended()
        manager.close()
        shutdown.finish()


def _open_hub(
    manager: SimulationManager, config: ServerConfig, log: RecentLog
) -> Optional[other_nodes.OtherLocalisers]:
    """Opens the topics and services other than those of plugins.

    Returns:
        The watch for other localisers, if the server sends map -> odom.
    """
    files = ClientFiles(manager.world, config.state_folder)
    hub = open_hub(manager, files, log=log, **config.hub)
    if config.realtime_priority:
        manager.on_tick.append(ThreadPriority().update)
    manager.on_tick.append(SlowPluginWatch().update)
    offer_services(hub)
    placed = hub.map_to_odom
    return other_nodes.OtherLocalisers(lambda: placed.frames) if placed is not None else None


def exclude_from_garbage_collection() -> None:
    """Excludes existing objects, libraries and the loaded world, from garbage collection.

    A full collection would otherwise traverse them all, which happens above all while models are
    spawned, and takes longer than the time between two steps. Objects are still freed when their
    last reference goes, as a model and its plugins are when the model is deleted; only reference
    cycles among them are not.
    """
    gc.collect()
    gc.freeze()


def _raise_file_limit() -> None:
    """Raises the soft limit of open files as far as the hard limit allows; warns if that is low.

    Each subscriber needs a connection, which is an open file: a recorder of a thousand robots needs
    some thousands.
    """
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    limit = _ENOUGH_FILES if hard == resource.RLIM_INFINITY else min(hard, _ENOUGH_FILES)
    if soft == resource.RLIM_INFINITY or soft >= limit:
        limit = soft
    else:
        resource.setrlimit(resource.RLIMIT_NOFILE, (limit, hard))
    if limit != resource.RLIM_INFINITY and limit < _FEW_FILES:
        logger.warning(
            "at most %d open files (ulimit -Hn): too few for many robots with many subscribers",
            limit,
        )


def offer_services(hub: Hub) -> None:
    """Offers all services of a simulation; rospy calls each on a thread of its own.

    Errors are reported as `ModelError: a model named ...`: the `message` begins with the name of an
    exception class (see `flatland_server.exceptions`; `ValueError` for a rate), for programs to
    tell errors apart.
    """
    for name, service in hub.services.items():
        rospy.Service(name, service.type.ros_class, partial(_handle, name, service))
    hub.on_open.append(_set_world_path)


def _handle(name: str, service: Service, request: Any) -> Any:
    try:
        response = service.answer(request)
    except ServiceError as error:
        rospy.logwarn("%s: %s", name, error)
        raise rospy.ServiceException(str(error)) from None
    if not getattr(response, "success", True):
        rospy.logwarn("%s: %s", name, response.message)
    return response


def _set_world_path(path: str) -> None:
    """Sets ~world_path, if the ROS master answers in time; it may be stopped, or dead."""
    name = "~world_path"
    try:
        Master(rosgraph.get_master_uri()).ask("setParam", rospy.resolve_name(name), path)
    except NO_ANSWER:
        rospy.logwarn("the ROS master does not answer: %s is not set to %s", name, path)
