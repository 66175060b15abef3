"""The services that control time and state: steps, resets, and saved states."""

import logging
from concurrent.futures import Future
from typing import Any, Dict, Optional

from flatland_server.arguments import steps_in
from flatland_server.exceptions import FlatlandError, UsageError
from flatland_server.hub.hub import Hub
from flatland_server.messages import ros_time
from flatland_server.simulation.world_config import WorldConfig
from flatland_server.simulation.world_state import read_state, write_state

logger = logging.getLogger(__name__)

_CONTROL_PERIOD = 0.1
"""Simulated time of a call of /step_world, unless the server has another [s]."""
_DEFAULT_TIMEOUT = 10.0
"""Real time that /step waits for messages if the request does not say [s]."""


class StateServices:
    """Offers /step, /step_world, /reset, /reload_world, /open_world, /save_state, /load_state,
    /seek, /change_rate, /pause, /resume and /toggle_pause, and obeys the topic `step_world`.

    Like the services for models, they read and write files on the threads of clients, and change
    the world on the simulation's thread, between two steps.

    Args:
        hub: hub that offers the services, and has the simulation.
        control_period: simulated time of a call of /step_world [s]; by default 0.1 s, or one step
            if that is no multiple of the steps.
        train_mode: whether time stands still between requests for steps.

    Raises:
        UsageError: the control period is no multiple of the steps.
    """

    def __init__(
        self, hub: Hub, control_period: Optional[float] = None, train_mode: bool = False
    ) -> None:
        self._manager = manager = hub.manager
        self._hub = hub
        self._transport = transport = hub.transport
        self._control_steps = _control_steps(control_period, manager.timekeeper.step_size)
        self._train_mode = train_mode
        self._has_told = False  # that time goes on
        if train_mode:
            manager.pause()
        actions = {
            "step": ("flatland_msgs/Step", self._step),
            "step_world": ("std_srvs/Empty", self._step_world),
            "reset": ("flatland_msgs/Reset", self._reset),
            "reload_world": ("std_srvs/Trigger", self._reload_world),
            "open_world": ("flatland_msgs/OpenWorld", self._open_world),
            "save_state": ("flatland_msgs/SaveState", self._save_state),
            "load_state": ("flatland_msgs/LoadState", self._load_state),
            "seek": ("flatland_msgs/Seek", self._seek),
            "change_rate": ("flatland_msgs/ChangeRate", self._change_rate),
            "pause": ("std_srvs/Empty", lambda _: transport.call(manager.pause)),
            "resume": ("std_srvs/Empty", lambda _: transport.call(manager.resume)),
            "toggle_pause": ("std_srvs/Empty", lambda _: transport.call(manager.toggle_pause)),
        }
        for name, (kind, action) in actions.items():
            hub.offer(name, kind, action)
        hub.obey(
            "step_world",
            "flatland_msgs/StepWorld",
            lambda message: self._advance_by(message.required_time),
        )

    def _step(self, request: Any) -> Dict[str, Any]:
        expected = [self._transport.resolve(topic) for topic in request.expect]
        timeout = request.timeout or _DEFAULT_TIMEOUT
        manager = self._manager
        done = self._transport.call(lambda: manager.request_steps(request.steps, expected, timeout))
        return {"time": ros_time(self._transport.wait(done))}

    def _step_world(self, request: Any) -> None:
        """The service /step_world. Its response is empty: errors are those of the call."""
        self._transport.wait(self._transport.call(lambda: self._advance(self._control_steps)))

    def _advance_by(self, duration: float) -> None:
        """Makes the steps of a duration [s]; one step if it is 0."""
        step_size = self._manager.timekeeper.step_size
        self._advance(steps_in(duration, step_size, "required_time") if duration else 1)

    def _advance(self, count: int) -> "Future[int]":
        if self._manager.is_stepping and not self._train_mode and not self._has_told:
            self._has_told = True
            logger.info("time goes on between calls of /step_world: train_mode is not set")
        return self._manager.advance(count, then_pause=self._train_mode)

    def _change_rate(self, request: Any) -> None:
        self._transport.call(lambda: self._manager.change_rate(request.rate))

    def _reset(self, request: Any) -> None:
        seed = request.seed if request.new_seed else None
        keep_time = not request.restart_time
        self._hub.change(lambda: self._manager.reset(seed, keep_time=keep_time))

    def _reload_world(self, request: Any) -> Dict[str, Any]:
        registry = self._manager.world.registry
        config: WorldConfig = self._manager.world.read_config()

        def reload() -> None:
            if self._manager.world.registry is not registry:
                raise FlatlandError("another world was loaded while the file was read; try again")
            self._manager.reload(config)

        self._hub.change(reload)
        return {"message": f"{config.path} is loaded"}

    def _open_world(self, request: Any) -> Dict[str, Any]:
        config: WorldConfig = self._manager.world.read_config(
            self._hub.files.world_file(request.path)
        )
        self._hub.change(lambda: self._manager.reload(config, keep_time=False))
        for tell in self._hub.on_open:
            tell(str(config.path))
        return {"message": f"{config.path} is open"}

    def _save_state(self, request: Any) -> Dict[str, Any]:
        path = self._hub.files.state(request.path)
        manager = self._manager
        state, without_hooks = self._transport.call(
            lambda: (manager.save_state(), manager.world.plugins_without_state_hooks)
        )
        write_state(path, state)
        message = ""
        if without_hooks:
            names = ", ".join(without_hooks)
            message = f"plugins without get_state, which start from scratch: {names}"
        return {"message": message, "without_hooks": without_hooks}

    def _load_state(self, request: Any) -> None:
        state = read_state(self._hub.files.state(request.path))
        self._hub.change(lambda: self._manager.load_state(state))

    def _seek(self, request: Any) -> None:
        def seek() -> None:
            if self._manager.history is None:
                raise FlatlandError("no history is kept; start the server with history:=true")
            self._manager.seek(request.time)
            self._manager.pause()  # else the sought time would have passed before it is seen

        self._hub.change(seek)


def _control_steps(control_period: Optional[float], step_size: float) -> int:
    """The steps of a call of /step_world."""
    if control_period is not None:
        return steps_in(control_period, step_size, "~control_period")
    try:
        return steps_in(_CONTROL_PERIOD, step_size, "")
    except UsageError:
        logger.info("/step_world makes one step, of %g s", step_size)
        return 1
