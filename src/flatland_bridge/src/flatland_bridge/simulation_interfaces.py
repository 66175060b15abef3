"""The services of simulation_interfaces 2.1, which Gazebo and Isaac Sim offer, too."""

from pathlib import Path
from typing import Any, Callable, Dict, List, Optional

from flatland_bridge import simulation_types
from flatland_bridge.simulation_entities import EntityServices
from flatland_bridge.simulation_results import Failure, Result, path_of, with_result
from flatland_server.exceptions import YamlError
from flatland_server.hub import Hub, told

_Resource = simulation_types.message("Resource")
_Features = simulation_types.message("SimulatorFeatures")
_State = simulation_types.message("SimulationState")
_WorldResource = simulation_types.message("WorldResource")
_Reset = simulation_types.service("ResetSimulation").request
_SetState = simulation_types.service("SetSimulationState").response
_LoadWorld = simulation_types.service("LoadWorld").response

FEATURES = (
    *("SPAWNING", "SPAWNING_RESOURCE_STRING", "SPAWNING_ENTITIES", "SPAWNABLES", "DELETING"),
    *("ENTITY_STATE_GETTING", "ENTITY_STATE_SETTING"),
    *("SIMULATION_RESET", "SIMULATION_RESET_SPAWNED"),
    *("SIMULATION_STATE_GETTING", "SIMULATION_STATE_SETTING", "SIMULATION_STATE_PAUSE"),
    *("STEP_SIMULATION_SINGLE", "STEP_SIMULATION_MULTIPLE"),
    *("WORLD_LOADING", "WORLD_INFO_GETTING", "AVAILABLE_WORLDS"),
)
"""The features that GetSimulatorFeatures names."""


class SimulationInterfaces:
    """The services, made of those that Flatland has itself.

    Args:
        hub: hub with Flatland's services, which gets these in addition.
        worlds: returns the files of the worlds that clients can open by name.
    """

    def __init__(self, hub: Hub, worlds: Callable[[], List[Path]]) -> None:
        self._manager = hub.manager
        self._worlds = worlds
        self._transport = hub.transport
        self._call = hub.call
        self._entities = EntityServices(hub)
        self._is_stopped = False  # it was, and has been paused since
        actions = {
            **self._entities.actions,
            "reset_simulation": ("ResetSimulation", self._reset_simulation),
            "get_simulation_state": ("GetSimulationState", self._get_state),
            "set_simulation_state": ("SetSimulationState", self._set_state),
            "step_simulation": ("StepSimulation", self._step),
            "load_world": ("LoadWorld", self._load_world),
            "get_current_world": ("GetCurrentWorld", self._get_world),
            "get_available_worlds": ("GetAvailableWorlds", self._get_worlds),
        }
        service = simulation_types.service
        hub.offer("get_simulator_features", service("GetSimulatorFeatures"), _features)
        for name, (kind, action) in actions.items():
            hub.offer(name, service(kind), with_result(action))

    def _reset_simulation(self, request: Any) -> None:
        scope = (request.scope or _Reset.SCOPE_ALL) & 7
        if scope == _Reset.SCOPE_SPAWNED:
            self._entities.delete_spawned()
        elif scope & _Reset.SCOPE_STATE and scope & _Reset.SCOPE_SPAWNED:
            self._call("reset", restart_time=bool(scope & _Reset.SCOPE_TIME))
        else:
            raise Failure(
                Result.RESULT_FEATURE_UNSUPPORTED,
                "a reset of the state deletes what was spawned, and time is not reset alone",
            )

    def _state(self) -> int:
        manager = self._manager
        if manager.is_stepping:
            return int(_State.STATE_PLAYING)
        is_stopped = self._is_stopped and manager.timekeeper.nanoseconds == 0
        return int(_State.STATE_STOPPED if is_stopped else _State.STATE_PAUSED)

    def _get_state(self, request: Any) -> Dict[str, Any]:
        return {"state": _State(self._transport.call(self._state))}

    def _set_state(self, request: Any) -> None:
        target = request.state.state
        if target not in (_State.STATE_STOPPED, _State.STATE_PLAYING, _State.STATE_PAUSED):
            raise Failure(
                Result.RESULT_FEATURE_UNSUPPORTED, "expected to be stopped, playing or paused"
            )
        if target == self._transport.call(self._state):
            raise Failure(
                _SetState.ALREADY_IN_TARGET_STATE, "the simulation is in this state already"
            )
        if target == _State.STATE_PLAYING:
            self._transport.call(self._manager.resume)
        else:
            self._transport.call(self._manager.pause)
        if target == _State.STATE_STOPPED:
            self._call("reset", restart_time=True)
        self._is_stopped = target == _State.STATE_STOPPED

    def _step(self, request: Any) -> None:
        if self._transport.call(self._state) == _State.STATE_PLAYING:
            raise Failure(Result.RESULT_OPERATION_FAILED, "the simulation is not paused")
        self._call("step", steps=request.steps or 1)

    def _load_world(self, request: Any) -> Dict[str, Any]:
        resource = request.world_resource
        if not resource.uri:
            if not resource.resource_string:
                raise Failure(_LoadWorld.NO_RESOURCE, "expected a URI")
            raise Failure(Result.RESULT_FEATURE_UNSUPPORTED, "a world is loaded by its URI only")
        try:
            self._call("open_world", path=path_of(resource.uri))
        except YamlError as error:
            raise Failure(_LoadWorld.RESOURCE_PARSE_ERROR, told(error)) from None
        self._transport.call(self._manager.pause)
        self._is_stopped = True
        return self._get_world(request)

    def _get_world(self, request: Any) -> Dict[str, Any]:
        path = self._manager.world.config.path
        return {"world": _world_resource(path)}

    def _get_worlds(self, request: Any) -> Dict[str, Any]:
        return {"worlds": [_world_resource(path) for path in self._worlds()]}


def _features(request: Any) -> Dict[str, Any]:
    numbers = [getattr(_Features, name) for name in FEATURES]
    return {"features": _Features(numbers, ["yaml"], "Flatland: model files, and their text")}


def _world_resource(path: Optional[Path]) -> Any:
    """The description of a world; of one without a file, an empty one."""
    if path is None:
        return _WorldResource()
    name = path.parent.name if path.name == "world.yaml" else path.name
    return _WorldResource(name=name, world_resource=_Resource(str(path), ""))
