"""A world that is simulated in this process, for clients of all protocols: `flatland serve`."""

from contextlib import ExitStack
from pathlib import Path
from typing import Any, Callable, Mapping, Optional, Sequence

from flatland2d.world_source import WorldSource, open_world
from flatland_bridge.rosbridge_server import Access, RosbridgeServer
from flatland_bridge.shared_transport import SharedTransport
from flatland_bridge.simulated_graph import SimulatedGraph
from flatland_server.simulation.simulation_manager import SimulationManager
from flatland_server.timekeeper import Timekeeper


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
        access: who may connect.
        rosbridge_port: of rosbridge and the page; 0 takes a free one.
        foxglove_port: of Foxglove; None opens none.

    Raises:
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
        rosbridge_port: int = 9090,
        foxglove_port: Optional[int] = None,
    ) -> None:
        self.transport = SharedTransport(params)
        opened = open_world(
            world,
            self.transport,
            seed=seed,
            simplify_map=0,
            model_folders=model_folders,
            loader=None,
        )
        self._stack = ExitStack()
        with ExitStack() as stack:
            self.manager = SimulationManager(opened, Timekeeper(step_size))
            stack.callback(self.manager.close)
            self.manager.change_rate(rate)
            self.manager.is_paused = is_paused
            self.graph = SimulatedGraph(self.manager, state_folder)
            self.rosbridge = RosbridgeServer(self.graph, rosbridge_port, access)
            stack.callback(self.rosbridge.close)
            self.foxglove: Any = None
            if foxglove_port is not None:
                from flatland_bridge.foxglove_server import FoxgloveServer

                self.foxglove = FoxgloveServer(self.graph, access.host, foxglove_port)
                stack.callback(self.foxglove.close)
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
