"""The services of simulation_interfaces for entities, which are models."""

import math
import re
from itertools import count
from typing import Any, Dict, List, Tuple

from flatland_bridge import simulation_types
from flatland_bridge.simulation_results import Failure, Result, path_of, with_result
from flatland_server.config import LARGEST, namespace_problem, topic_name_problem
from flatland_server.exceptions import ModelError, YamlError, shortened
from flatland_server.geometry import Pose
from flatland_server.hub import FRAME_ID, Action, Hub, told
from flatland_server.messages import fill_pose, fill_twist, get, header, yaw_of
from flatland_server.models import Model

_Pose2D = get("geometry_msgs/Pose2D")
_Resource = simulation_types.message("Resource")
_EntityState = simulation_types.message("EntityState")
_SpawnResult = simulation_types.message("SpawnResult")
_Spawnable = simulation_types.message("Spawnable")

_SPAWN_FAILED = simulation_types.service("SpawnEntities").response.ENTITIES_SPAWN_FAILED
_BAD_POSE = simulation_types.service("SetEntityState").response.INVALID_POSE

_MOST_REPETITIONS = 3
"""Of a filter's pattern: with more, some take a long time to search."""
_WORLD_FRAMES = ("", "world", FRAME_ID)


class EntityServices:
    """Services that spawn, delete, show and move models.

    Args:
        hub: hub with the models; it records their changes.
    """

    def __init__(self, hub: Hub) -> None:
        self._manager = hub.manager
        self._edits = hub.edits
        self._transport = hub.transport
        self._call = hub.call

    @property
    def actions(self) -> Dict[str, Tuple[str, Action]]:
        """Their types and what they do, by their names."""
        return {
            "spawn_entity": ("SpawnEntity", self._spawn_entity),
            "spawn_entities": ("SpawnEntities", self._spawn_entities),
            "delete_entity": ("DeleteEntity", self._delete_entity),
            "get_entities": ("GetEntities", self._get_entities),
            "get_entities_states": ("GetEntitiesStates", self._get_entities_states),
            "get_entity_state": ("GetEntityState", self._get_entity_state),
            "set_entity_state": ("SetEntityState", self._set_entity_state),
            "get_spawnables": ("GetSpawnables", self._get_spawnables),
        }

    def delete_spawned(self) -> None:
        """Deletes the models that are not in the world's file."""
        world = self._manager.world

        def spawned() -> List[str]:
            own = {entry.name for entry in world.config.models}
            return [name for name in world.models if name not in own]

        self._call("delete_models", name=self._transport.call(spawned))

    def _spawn_entity(self, request: Any) -> Dict[str, Any]:
        return {"entity_name": self._spawn(request)}

    def _spawn_entities(self, request: Any) -> Dict[str, Any]:
        results = []
        for each in request.spawn_requests:
            fields = with_result(self._spawn_entity)(each)
            results.append(_SpawnResult(**(fields or {})))
        failed = [each for each in results if each.result.result != Result.RESULT_OK]
        if failed:
            text = f"{len(failed)} of {len(results)} are not spawned"
            return {"result": Result(_SPAWN_FAILED, text), "results": results}
        return {"results": results}

    def _spawn(self, request: Any) -> str:
        """Spawns a model; returns its name."""
        resource = request.entity_resource
        if not (resource.uri or resource.resource_string):
            raise Failure(_SpawnResult.NO_RESOURCE, "expected a URI or a resource string")
        name = self._free_name(request)
        problem = namespace_problem(request.entity_namespace)
        if problem:
            raise Failure(_SpawnResult.NAMESPACE_INVALID, problem)
        start = request.initial_pose
        pose = _pose_in_world(start.header, start.pose, _SpawnResult.INVALID_POSE)
        service = "spawn_model" if resource.uri else "spawn_model_from_string"
        try:
            self._call(
                service,
                yaml_path=path_of(resource.uri) or resource.resource_string,
                name=name,
                ns=request.entity_namespace,
                pose=_Pose2D(*pose),
            )
        except YamlError as error:
            raise Failure(_SpawnResult.RESOURCE_PARSE_ERROR, told(error)) from None
        return name

    def _free_name(self, request: Any) -> str:
        wanted, may_rename = str(request.name), request.allow_renaming
        problem = topic_name_problem(wanted) if wanted or not may_rename else None
        if problem:
            raise Failure(_SpawnResult.NAME_INVALID, problem)
        taken = self._transport.call(lambda: list(self._manager.world.models))
        if wanted and wanted not in taken:
            return wanted
        if not may_rename:
            raise Failure(_SpawnResult.NAME_NOT_UNIQUE, f'a model named "{wanted}" is there')
        stem = wanted or "entity"
        return next(name for name in (f"{stem}_{n}" for n in count(2)) if name not in taken)

    def _delete_entity(self, request: Any) -> None:
        self._transport.call(lambda: self._model(request.entity))
        self._call("delete_model", name=request.entity)

    def _model(self, name: str) -> Model:
        """A model; on the simulation's thread.

        Raises:
            Failure: there is none of this name.
        """
        try:
            return self._manager.world.get_model(name)
        except ModelError as error:
            raise Failure(Result.RESULT_NOT_FOUND, str(error)) from None

    def _get_entities(self, request: Any) -> Dict[str, Any]:
        models = self._transport.call(lambda: self._filtered(request.filters))
        return {"entities": [model.name for model in models]}

    def _get_entities_states(self, request: Any) -> Dict[str, Any]:
        def read() -> Dict[str, Any]:
            models = self._filtered(request.filters)
            return {
                "entities": [model.name for model in models],
                "states": [self._state_of(model) for model in models],
            }

        return self._transport.call(read)

    def _get_entity_state(self, request: Any) -> Dict[str, Any]:
        return {"state": self._transport.call(lambda: self._state_of(self._model(request.entity)))}

    def _filtered(self, filters: Any) -> List[Model]:
        if filters.categories or filters.tags.tags or filters.bounds.type:
            raise Failure(
                Result.RESULT_FEATURE_UNSUPPORTED,
                "entities have no categories, tags or bounds here",
            )
        pattern = _pattern(filters.filter)
        return [model for name, model in self._manager.world.models.items() if pattern.search(name)]

    def _state_of(self, model: Model) -> Any:
        state = _EntityState(header=header(self._manager.timekeeper.nanoseconds, FRAME_ID))
        fill_pose(state.pose, model.pose)
        fill_twist(state.twist, *model.base.physics_body.velocity)
        return state

    def _set_entity_state(self, request: Any) -> None:
        state = request.state
        pose = _pose_in_world(state.header, state.pose, _BAD_POSE)
        linear, turn = state.twist.linear, state.twist.angular.z

        def change() -> None:
            model = self._model(request.entity)
            velocities = [body.velocity for body in model.physics_bodies]
            if request.set_twist:
                _require_possible(model, math.hypot(linear.x, linear.y), turn)
            if request.set_pose:
                self._edits.move(request.entity, pose)
            x, y, _ = model.base.physics_body.pose
            for body, velocity in zip(model.physics_bodies, velocities):
                dx, dy = body.pose[0] - x, body.pose[1] - y
                turning = (linear.x - turn * dy, linear.y + turn * dx, turn)
                body.velocity = turning if request.set_twist else velocity

        self._transport.call(change)

    def _get_spawnables(self, request: Any) -> Dict[str, Any]:
        folders = self._manager.world.config.model_folders
        files = [file for folder in folders for file in sorted(folder.glob("*.model.yaml"))]
        text = (
            f"no such sources: {shortened(', '.join(request.sources))}" if request.sources else ""
        )
        spawnables = [_Spawnable(entity_resource=_Resource(uri=str(file))) for file in files]
        return {"result": Result(Result.RESULT_OK, text), "spawnables": spawnables}


def _require_possible(model: Model, speed: float, turn: float) -> None:
    """Raises a Failure unless a model can have a speed [m/s] and a yaw rate [rad/s]."""
    if any(body.type == "static" for body in model.config.bodies):
        raise Failure(Result.RESULT_OPERATION_FAILED, "a static body does not move")
    x, y, _ = model.base.physics_body.pose
    reach = max(math.hypot(body.pose[0] - x, body.pose[1] - y) for body in model.physics_bodies)
    if not (abs(turn) <= LARGEST and speed + abs(turn) * reach <= LARGEST):  # or NaN
        text = f"expected a twist of up to {LARGEST:g} m/s and rad/s"
        raise Failure(Result.RESULT_OPERATION_FAILED, text)


def _pose_in_world(frame: Any, pose: Any, code: int) -> Pose:
    """A pose of a request; an orientation of zeros is none.

    Raises:
        Failure: it has this code.
    """
    if frame.frame_id not in _WORLD_FRAMES:
        found = shortened(frame.frame_id)
        raise Failure(code, f'expected a pose in the frame {FRAME_ID}, found "{found}"')
    q = pose.orientation
    length = math.hypot(q.x, q.y, q.z, q.w)
    place = Pose(pose.position.x, pose.position.y, yaw_of(q) if length else 0.0)
    if not place.is_finite() or (length and abs(length - 1.0) > 0.01):
        raise Failure(code, "expected finite numbers, and a quaternion of length 1")
    return place


def _pattern(text: str) -> "re.Pattern[str]":
    """A filter's regular expression, of a kind that is searched fast.

    Raises:
        Failure: it is none.
    """
    repetitions = sum(map(text.count, "*+?"))
    if len(text) > 255 or repetitions > _MOST_REPETITIONS or set("(){}\\") & set(text):
        raise Failure(
            Result.RESULT_FEATURE_UNSUPPORTED,
            f"expected a pattern without ( ) {{ }} \\, with at most {_MOST_REPETITIONS} of * + ?",
        )
    try:
        return re.compile(text)
    except re.error as error:
        raise Failure(Result.RESULT_OPERATION_FAILED, f"filter: {error}") from None
