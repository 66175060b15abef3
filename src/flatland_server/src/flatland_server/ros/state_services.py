"""The services that control time and state: steps, resets, and saved states."""

from concurrent.futures import Future
from typing import Any, Callable, Type

import rosgraph
import rospy
from flatland_msgs.srv import (
    LoadState,
    LoadStateRequest,
    LoadStateResponse,
    OpenWorld,
    OpenWorldRequest,
    OpenWorldResponse,
    Reset,
    ResetRequest,
    ResetResponse,
    SaveState,
    SaveStateRequest,
    SaveStateResponse,
    Seek,
    SeekRequest,
    SeekResponse,
    Step,
    StepRequest,
    StepResponse,
    StepWorldRequest,
    StepWorldResponse,
)
from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse

from flatland_server.arguments import steps_in
from flatland_server.exceptions import FlatlandError
from flatland_server.messages import ros_time
from flatland_server.ros.client_files import ClientFiles, told
from flatland_server.ros.ros_transport import REGISTRATION_LIMIT, RosTransport
from flatland_server.ros.rospy_patches.master_calls import NO_ANSWER, Master
from flatland_server.simulation.simulation_manager import SimulationManager
from flatland_server.simulation.world_config import WorldConfig
from flatland_server.simulation.world_state import read_state, write_state

Offer = Callable[[str, Any, Type[Any], Callable[[Any], Any]], None]

_DEFAULT_TIMEOUT = 10.0
"""Real time that /step waits for messages if the request does not say [s]."""


class StateServices:
    """Offers /step, /reset, /reload_world, /open_world, /save_state, /load_state and /seek.

    Like the services for models, they read and write files on rospy's threads, and change the world
    on the simulation's thread, between two steps.

    Args:
        manager: the simulation.
        transport: hands calls over to the simulation's thread.
        files: finds the files that clients name.
        offer: offers a service; see `ServiceManager`.
        control_period: simulated time of a call of /step_world [s].
    """

    def __init__(
        self,
        manager: SimulationManager,
        transport: RosTransport,
        files: ClientFiles,
        offer: Offer,
        control_period: float,
    ) -> None:
        self._manager = manager
        self._files = files
        self._transport = transport
        self._control_period = control_period
        offer("step", Step, StepResponse, self._step)
        offer("reset", Reset, ResetResponse, self._reset)
        offer("reload_world", Trigger, TriggerResponse, self._reload_world)
        offer("open_world", OpenWorld, OpenWorldResponse, self._open_world)
        offer("save_state", SaveState, SaveStateResponse, self._save_state)
        offer("load_state", LoadState, LoadStateResponse, self._load_state)
        offer("seek", Seek, SeekResponse, self._seek)

    def _step(self, request: StepRequest) -> StepResponse:
        expected = [rospy.resolve_name(topic) for topic in request.expect]
        timeout = request.timeout or _DEFAULT_TIMEOUT
        manager = self._manager
        done = self._transport.call(lambda: manager.request_steps(request.steps, expected, timeout))
        nanoseconds = self._transport.wait(done)
        return StepResponse(success=True, time=ros_time(nanoseconds))

    def step_world(self, request: StepWorldRequest) -> StepWorldResponse:
        """The service /step_world. Its response is empty: errors are exceptions in the client.

        Args:
            request: empty.

        Raises:
            rospy.ServiceException: the steps cannot be made.
        """
        manager = self._manager

        def begin() -> "Future[int]":
            count = steps_in(self._control_period, manager.timekeeper.step_size, "~control_period")
            manager.pause()
            return manager.request_steps(count)

        try:
            done = self._transport.call(begin)
            self._transport.wait(done)
        except FlatlandError as error:
            rospy.logwarn("step_world: %s", told(error))
            raise rospy.ServiceException(told(error)) from None
        return StepWorldResponse()

    def _reset(self, request: ResetRequest) -> None:
        seed = request.seed if request.new_seed else None
        keep_time = not request.restart_time
        self._change(lambda: self._manager.reset(seed, keep_time=keep_time))

    def _reload_world(self, request: TriggerRequest) -> TriggerResponse:
        registry = self._manager.world.registry
        config: WorldConfig = self._manager.world.read_config()

        def reload() -> None:
            if self._manager.world.registry is not registry:
                raise FlatlandError("another world was loaded while the file was read; try again")
            self._manager.reload(config)

        self._change(reload)
        return TriggerResponse(success=True, message=f"{config.path} is loaded")

    def _open_world(self, request: OpenWorldRequest) -> OpenWorldResponse:
        config: WorldConfig = self._manager.world.read_config(self._files.world_file(request.path))
        self._change(lambda: self._manager.reload(config, keep_time=False))
        _set_param("~world_path", str(config.path))  # viewers show it
        return OpenWorldResponse(success=True, message=f"{config.path} is open")

    def _save_state(self, request: SaveStateRequest) -> SaveStateResponse:
        path = self._files.state(request.path)
        manager = self._manager
        state, without_hooks = self._transport.call(
            lambda: (manager.save_state(), manager.world.plugins_without_state_hooks)
        )
        write_state(path, state)
        message = ""
        if without_hooks:
            names = ", ".join(without_hooks)
            message = f"plugins without get_state, which start from scratch: {names}"
        return SaveStateResponse(True, message, without_hooks)

    def _load_state(self, request: LoadStateRequest) -> None:
        state = read_state(self._files.state(request.path))
        self._change(lambda: self._manager.load_state(state))

    def _seek(self, request: SeekRequest) -> None:
        def seek() -> None:
            if self._manager.history is None:
                raise FlatlandError("no history is kept; start the server with history:=true")
            self._manager.seek(request.time)
            self._manager.pause()  # else the moment would be gone before it is seen

        self._change(seek)

    def _change(self, action: Callable[[], None]) -> None:
        """Rebuilds the world on the simulation's thread."""

        def change() -> None:
            with self._transport.rospy_calls.batch_registration():
                action()

        self._transport.call(change)
        self._transport.rospy_calls.wait_until_registered(REGISTRATION_LIMIT)


def _set_param(name: str, value: str) -> None:
    """Sets a parameter, if the ROS master answers in time; it may be stopped, or dead."""
    try:
        Master(rosgraph.get_master_uri()).set_parameter(rospy.resolve_name(name), value)
    except NO_ANSWER:
        rospy.logwarn("the ROS master does not answer: %s is not set to %s", name, value)
