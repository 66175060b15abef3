"""The types of simulation_interfaces 2.1, in the shorthand of `standard_definitions`.

https://github.com/ros-simulation/simulation_interfaces. Names, fields and their order are those of
the standard, so that type hashes agree.
"""

from typing import Any

from flatland_server.messages import ServiceType, add, get, written_out

PACKAGE = "simulation_interfaces"

_MESSAGES = """
Result: uint8 RESULT_FEATURE_UNSUPPORTED=0 RESULT_OK=1 RESULT_NOT_FOUND=2 RESULT_INCORRECT_STATE=3
    RESULT_OPERATION_FAILED=4; uint8 result; string error_message
Resource: string uri resource_string
Bounds: uint8 TYPE_EMPTY=0 TYPE_BOX=1 TYPE_CONVEX_HULL=2 TYPE_SPHERE=3; uint8 type;
    geometry_msgs/Vector3[] points
EntityCategory: uint8 CATEGORY_OBJECT=0 CATEGORY_ROBOT=1 CATEGORY_HUMAN=2
    CATEGORY_DYNAMIC_OBJECT=4 CATEGORY_STATIC_OBJECT=5; uint8 category
TagsFilter: string[] tags; uint8 FILTER_MODE_ANY=0 FILTER_MODE_ALL=1; uint8 filter_mode
EntityFilters: string filter; EntityCategory[] categories; TagsFilter tags; Bounds bounds
EntityState: std_msgs/Header header; geometry_msgs/Pose pose; geometry_msgs/Twist twist;
    geometry_msgs/Accel acceleration
SimulationState: uint8 STATE_STOPPED=0 STATE_PLAYING=1 STATE_PAUSED=2 STATE_QUITTING=3
    STATE_NO_WORLD=4 STATE_LOADING_WORLD=5; uint8 state
SimulatorFeatures: uint8 SPAWNING=0 DELETING=1 NAMED_POSES=2 POSE_BOUNDS=3 ENTITY_TAGS=4
    ENTITY_BOUNDS=5 ENTITY_BOUNDS_BOX=6 ENTITY_BOUNDS_CONVEX=7 ENTITY_CATEGORIES=8
    SPAWNING_RESOURCE_STRING=9 ENTITY_STATE_GETTING=10 ENTITY_STATE_SETTING=11
    ENTITY_INFO_GETTING=12 ENTITY_INFO_SETTING=13 SPAWNABLES=14 SIMULATION_RESET=20
    SIMULATION_RESET_TIME=21 SIMULATION_RESET_STATE=22 SIMULATION_RESET_SPAWNED=23
    SIMULATION_STATE_GETTING=24 SIMULATION_STATE_SETTING=25 SIMULATION_STATE_PAUSE=26
    STEP_SIMULATION_SINGLE=31 STEP_SIMULATION_MULTIPLE=32 STEP_SIMULATION_ACTION=33
    WORLD_LOADING=40 WORLD_RESOURCE_STRING=41 WORLD_TAGS=42 WORLD_UNLOADING=43
    WORLD_INFO_GETTING=44 AVAILABLE_WORLDS=45 SPAWNING_ENTITIES=50; uint16[] features;
    string[] spawn_formats; string custom_info
SpawnEntity: string name; bool allow_renaming; Resource entity_resource; string entity_namespace;
    geometry_msgs/PoseStamped initial_pose
SpawnResult: uint8 NAME_NOT_UNIQUE=101 NAME_INVALID=102 UNSUPPORTED_FORMAT=103 NO_RESOURCE=104
    NAMESPACE_INVALID=105 RESOURCE_PARSE_ERROR=106 MISSING_ASSETS=107 UNSUPPORTED_ASSETS=108
    INVALID_POSE=109; Result result; string entity_name
Spawnable: Resource entity_resource; string description; Bounds spawn_bounds
WorldResource: string name; Resource world_resource; string description; string[] tags
"""
_SERVICES = """
GetSimulatorFeaturesRequest:
GetSimulatorFeaturesResponse: SimulatorFeatures features
SpawnEntityRequest: string name; bool allow_renaming; Resource entity_resource;
    string entity_namespace; geometry_msgs/PoseStamped initial_pose
SpawnEntityResponse: uint8 NAME_NOT_UNIQUE=101 NAME_INVALID=102 UNSUPPORTED_FORMAT=103
    NO_RESOURCE=104 NAMESPACE_INVALID=105 RESOURCE_PARSE_ERROR=106 MISSING_ASSETS=107
    UNSUPPORTED_ASSETS=108 INVALID_POSE=109; Result result; string entity_name
SpawnEntitiesRequest: SpawnEntity[] spawn_requests
SpawnEntitiesResponse: uint8 ENTITIES_SPAWN_FAILED=150; Result result; SpawnResult[] results
DeleteEntityRequest: string entity
DeleteEntityResponse: Result result
GetEntitiesRequest: EntityFilters filters
GetEntitiesResponse: Result result; string[] entities
GetEntitiesStatesRequest: EntityFilters filters
GetEntitiesStatesResponse: Result result; string[] entities; EntityState[] states
GetEntityStateRequest: string entity
GetEntityStateResponse: Result result; EntityState state
SetEntityStateRequest: string entity; EntityState state; bool set_pose set_twist set_acceleration
SetEntityStateResponse: uint8 INVALID_POSE=101; Result result
GetSpawnablesRequest: string[] sources
GetSpawnablesResponse: Result result; Spawnable[] spawnables
ResetSimulationRequest: uint8 SCOPE_DEFAULT=0 SCOPE_TIME=1 SCOPE_STATE=2 SCOPE_SPAWNED=4
    SCOPE_ALL=255; uint8 scope
ResetSimulationResponse: Result result
GetSimulationStateRequest:
GetSimulationStateResponse: SimulationState state; Result result
SetSimulationStateRequest: SimulationState state
SetSimulationStateResponse: uint8 ALREADY_IN_TARGET_STATE=101 STATE_TRANSITION_ERROR=102
    INCORRECT_TRANSITION=103; Result result
StepSimulationRequest: uint64 steps
StepSimulationResponse: Result result
LoadWorldRequest: Resource world_resource;
    bool fail_on_unsupported_element ignore_missing_or_unsupported_assets
LoadWorldResponse: uint8 UNSUPPORTED_FORMAT=101 NO_RESOURCE=102 RESOURCE_PARSE_ERROR=103
    MISSING_ASSETS=104 UNSUPPORTED_ASSETS=105 UNSUPPORTED_ELEMENTS=106; Result result;
    WorldResource world
GetCurrentWorldRequest:
GetCurrentWorldResponse: uint8 NO_WORLD_LOADED=101; Result result; WorldResource world
GetAvailableWorldsRequest: string[] additional_sources; TagsFilter filter;
    bool offline_only continue_on_error
GetAvailableWorldsResponse: uint8 DEFAULT_SOURCES_FAILED=101; Result result; WorldResource[] worlds
"""

for _name, _definition in written_out(PACKAGE, _MESSAGES + _SERVICES.lstrip()).items():
    add(_name, _definition)


def message(name: str) -> Any:
    """The class of a message type of the standard."""
    return get(f"{PACKAGE}/{name}")


def service(name: str) -> ServiceType:
    """A service type of the standard."""
    request, response = (message(f"{name}{part}") for part in ("Request", "Response"))
    return ServiceType(f"{PACKAGE}/{name}", request, response)
