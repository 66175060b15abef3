"""A world that is simulated in this process, for clients of all protocols: `flatland serve`."""

import ctypes
import math
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, suppress
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, Callable, Mapping, Optional, Sequence

from flatland2d.world_source import WorldSource, open_world
from flatland_bridge.budget import CLIENT_MEMORY
from flatland_bridge.client_calls import MOST_AT_ONCE
from flatland_bridge.foxglove_session import SUBPROTOCOLS, FoxgloveSession
from flatland_bridge.graph import BridgeError, Graph
from flatland_bridge.rosbridge_session import Providers, RosbridgeSession
from flatland_bridge.shared_transport import SharedTransport
from flatland_bridge.simulated_graph import SimulatedGraph
from flatland_bridge.websocket_server import MOST_CLIENTS, Access, Endpoint, WebSocketServer
from flatland_server.exceptions import MissingPackageError, pip_install
from flatland_server.messages import set_stamp_offset
from flatland_server.simulation import SimulationManager, WallTimekeeper
from flatland_server.timekeeper import Timekeeper

if TYPE_CHECKING:
    from flatland_bridge.ros2.node import Ros2Node

ROSBRIDGE, FOXGLOVE = "rosbridge", "Foxglove"

_WORKERS = MOST_AT_ONCE * MOST_CLIENTS
"""Threads for calls of services, which begin when they are needed: no client waits for another."""

_MMAP_THRESHOLD, _LARGE_BLOCK = -3, 131_072
"""An option of mallopt, M_MMAP_THRESHOLD, and its default, which would grow [bytes]."""


def serve_clients(
    graph: Graph,
    rosbridge_port: int,
    foxglove_port: Optional[int],
    access: Access,
    client_memory: int,
) -> WebSocketServer:
    """Serves the clients of all protocols, until it is closed.

    Args:
        graph: the topics and services.
        rosbridge_port: of rosbridge and the page; 0 takes a free one.
        foxglove_port: of Foxglove; 0 takes a free one, None serves no Foxglove.
        access: the clients that may connect.
        client_memory: bytes that are kept for each client.

    Raises:
        BridgeError: a port or the address cannot be used.
    """
    _return_large_blocks()
    pool, providers = ThreadPoolExecutor(_WORKERS, "service"), Providers()
    endpoints = [
        Endpoint(
            ROSBRIDGE,
            rosbridge_port,
            lambda budget: RosbridgeSession(graph, pool, providers, budget),
            has_page=True,
        )
    ]
    if foxglove_port is not None:
        endpoints.append(
            Endpoint(
                FOXGLOVE,
                foxglove_port,
                lambda budget: FoxgloveSession(graph, pool, budget),
                SUBPROTOCOLS,
            )
        )
    return WebSocketServer(endpoints, access, client_memory)


def _return_large_blocks() -> None:
    """Lets the C library return large blocks to the system when they are freed.

    It would keep those of former clients: after 40 that did not read, 290 MB instead of 5.
    """
    with suppress(AttributeError):  # it is not glibc
        ctypes.CDLL(None).mallopt(_MMAP_THRESHOLD, _LARGE_BLOCK)


def open_ros2(access: Access, arguments: Sequence[str] = (), cmd_vel_type: str = "") -> "Ros2Node":
    """A node of ROS 2, for `Server`.

    Args:
        access: the clients that may connect.
        arguments: as for `Ros2Node`.
        cmd_vel_type: as for `Ros2Node`.

    Raises:
        FlatlandError: it cannot be had.
    """
    try:
        from flatland_bridge.ros2.node import Ros2Node
    except ImportError as error:
        if error.name is None or error.name.startswith("flatland"):
            raise
        wanted = pip_install("ros2-jazzy")
        raise MissingPackageError(
            f"ROS 2 needs {error.name}: source a ROS 2 first, or {wanted} (or ros2-kilted)"
        ) from None
    if access.token is not None:
        raise BridgeError("ROS 2 has no token: leave out either --token or --ros2")
    return Ros2Node(arguments, cmd_vel_type, only_here=access.is_local)


class Server:
    """A simulation and its clients.

    Args:
        world: the name of a shipped world, or the path of a world file.
        seed: of all random numbers.
        step_size: length of a step [s].
        rate: simulated seconds per second of real time; infinity is as fast as the machine can.
        params: parameters by absolute name.
        model_folders: folders to search for model files that are not beside the world file.
        state_folder: where clients may save and load states; by default they cannot.
        is_paused: whether it begins with a pause.
        access: the clients that may connect.
        rosbridge_port: of rosbridge and the page; 0 takes a free one, None serves ROS 2 alone.
        foxglove_port: of Foxglove; 0 takes a free one, None serves no Foxglove.
        client_memory: bytes that are kept for each client; beyond them it is disconnected.
        wall_clock_stamps: whether stamps are of real time, without /clock; the rate has to be 1.
        tf_by_namespace: whether transforms of robots in namespaces go to NAMESPACE/tf.
        ros2: a node of ROS 2 that shows the topics and services; it is closed with the server.
        simplify_map: as for `World.from_file`.
        command_age: as for `SimulationManager`.
        trusts_clients: whether clients may name any file, if there is no state folder.
        hub: further options of `open_hub`.

    Raises:
        UsageError: stamps are of real time, and the rate is not 1.
        FlatlandError: the world cannot be loaded, or a port cannot be used.
    """

    def __init__(
        self,
        world: WorldSource,
        *,
        seed: int = 0,
        step_size: float = 0.005,
        rate: float = 1.0,
        params: Mapping[str, Any] = {},
        model_folders: Sequence[Path] = (),
        state_folder: Optional[Path] = None,
        is_paused: bool = False,
        access: Access = Access(),  # noqa: B008 (immutable)
        rosbridge_port: Optional[int] = 9090,
        foxglove_port: Optional[int] = 8765,
        client_memory: int = CLIENT_MEMORY,
        wall_clock_stamps: bool = False,
        tf_by_namespace: bool = False,
        ros2: "Optional[Ros2Node]" = None,
        simplify_map: int = 0,
        command_age: float = math.inf,
        trusts_clients: bool = False,
        **hub: Any,
    ) -> None:
        self.transport = SharedTransport(params)
        self.transport.tf_by_namespace = tf_by_namespace
        opened = open_world(
            world,
            self.transport,
            seed=seed,
            simplify_map=simplify_map,
            model_folders=model_folders,
            loader=None,
        )
        self._stack = ExitStack()
        with ExitStack() as stack:
            timekeeper = (WallTimekeeper if wall_clock_stamps else Timekeeper)(step_size)
            self.manager = SimulationManager(
                opened, timekeeper, rate / timekeeper.step_size, command_age=command_age
            )
            stack.callback(self.manager.close)
            stack.callback(set_stamp_offset, 0)  # for other simulations of this process
            self.manager.is_paused = is_paused
            name = str(world) if isinstance(world, (str, PathLike)) else None
            self.graph = SimulatedGraph(
                self.manager,
                state_folder,
                name,
                trusts_clients=trusts_clients,
                **hub,
            )
            if rosbridge_port is not None:
                self.clients = serve_clients(
                    self.graph, rosbridge_port, foxglove_port, access, client_memory
                )
                stack.callback(self.clients.close)
            if ros2 is not None:
                stack.callback(ros2.close)
                ros2.serve(self.graph)
            self._stack = stack.pop_all()

    def run(self, goes_on: Callable[[], bool]) -> None:
        """Simulates, on this thread.

        Args:
            goes_on: called often; the simulation ends when it returns False.
        """
        try:
            self.manager.run(goes_on)
        finally:
            self.transport.is_ending = True

    def close(self) -> None:
        """Disconnects all clients, and stops the plugins."""
        self.transport.is_ending = True
        self._stack.close()

    def __enter__(self) -> "Server":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
