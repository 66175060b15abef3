"""Small files in which each kind of world, layer, model and plugin occurs, for `key_reads`.

Samples differ in the values that defaults depend on: this reveals such defaults.
"""

import xml.etree.ElementTree as ElementTree
from functools import lru_cache
from pathlib import Path
from typing import Any, Dict, List, Tuple

from key_reads import Key, Observation, observed
from PIL import Image

from flatland_server.testing import WorldFiles

ROOT = Path(__file__).resolve().parents[2]
DECLARATIONS = ROOT / "src/flatland_plugins/flatland_plugins.xml"

DISC = {"type": "circle", "radius": 0.1, "density": 1}
SQUARE = {"type": "polygon", "points": [[0, 0], [1, 0], [1, 1], [0, 1]], "density": 1}
TRICYCLE: Dict[str, Any] = {
    "bodies": [
        {"name": "base_link", "footprints": [SQUARE]},
        {"name": "front_wheel", "footprints": [DISC]},
        {"name": "left_wheel", "pose": [-0.9, 0.35, 0], "footprints": [DISC]},
        {"name": "right_wheel", "pose": [-0.9, -0.35, 0], "footprints": [DISC]},
        {"name": "swivel", "pose": [0.9, 0, 0], "footprints": [DISC]},
    ],
    "joints": [
        {
            "type": "revolute",
            "name": "steering",
            "limits": [-1, 1],
            "bodies": [
                {"name": "base_link", "anchor": [0, 0]},
                {"name": "front_wheel", "anchor": [0, 0]},
            ],
        },
        {
            "type": "revolute",
            "name": "swivelling",
            "bodies": [
                {"name": "base_link", "anchor": [0.9, 0]},
                {"name": "swivel", "anchor": [0, 0]},
            ],
        },
        *(
            {
                "type": "weld",
                "name": f"{side}_axle",
                "bodies": [
                    {"name": "base_link", "anchor": [-0.9, y]},
                    {"name": f"{side}_wheel", "anchor": [0, 0]},
                ],
            }
            for side, y in (("left", 0.35), ("right", -0.35))
        ),
    ],
}
WHEELS = {
    "front_wheel_joint": "steering",
    "rear_left_wheel_joint": "left_axle",
    "rear_right_wheel_joint": "right_axle",
}
CAR = {
    "wheelbase": 0.9,
    "max_steer_angle": 0.5,
    "front_left_wheel_joint": "swivelling",
    "front_right_wheel_joint": "swivelling",
    "single_track": {
        **{"mass": 4, "inertia": 0.1, "center_of_mass": 0.4, "friction": 1},
        **{"front_stiffness": 5, "rear_stiffness": 5},
    },
}
NOISE = {"odom_pose_noise": [1, 2, 3], "odom_twist_noise": [1, 2, 3]}
LIMITS = {
    "linear_dynamics": {"acceleration_limit": 1},
    "angular_dynamics": {"acceleration_limit": 1},
}
ON_BASE = {"body": "base_link"}
PERSON = {
    "pose": [2, 0, 0],
    "goals": [[2, 3], [-2, 3]],
    "name": "walker",
    "speed": 1,
    "radius": 0.3,
    "legs": True,
    "color": [1, 1, 1, 1],
    "sees_robots": True,
    "yields": 0.5,
    "reaction_time": 0.5,
    "field_of_view": 3,
    "group": "friends",
}
PLUGINS: Dict[str, List[Dict[str, Any]]] = {
    "AckermannDrive": [
        {**ON_BASE, **CAR},
        {**ON_BASE, **CAR, **NOISE, **LIMITS},
        {**ON_BASE, **CAR, "odom_drift": [1, 1, 1]},
    ],
    "BoolSensor": [{}, {}],
    "Bumper": [{}],
    "Crowd": [
        {"pedestrians": [PERSON]},
        {
            "pedestrians": [{"pose": [0, 2, 0]}, {"pose": [0, 4, 0]}],
            "speed": 1,
            "radius": 0.3,
            "legs": True,
            "color": [1, 1, 1, 1],
            "random": {"count": 1, "area": [[-3, -3], [3, 3]]},
            "circle": {"count": 1, "radius": 5},
            "recording": {"file": "people.csv"},
        },
    ],
    "DiffDrive": [ON_BASE, {**ON_BASE, **NOISE, **LIMITS}, {**ON_BASE, "odom_drift": [1, 1, 1]}],
    "DummyModelPlugin": [{}],
    "DummyWorldPlugin": [{}],
    "Gps": [ON_BASE, ON_BASE],
    "Imu": [
        ON_BASE,
        {
            **ON_BASE,
            "orientation_noise": [1, 2, 3],
            "angular_velocity_noise": [1, 2, 3],
            "linear_acceleration_noise": [1, 2, 3],
        },
    ],
    "JointMotor": [
        {"joint": "steering", "max_torque": 1, "mode": "position"},
        {"joint": "swivelling", "max_torque": 1},
    ],
    "JointStatePublisher": [{}],
    "Laser": [
        {**ON_BASE, "range": 20, "angle": {"min": 0, "max": 1, "increment": 0.5}},
        {**ON_BASE, "range": 20, "angle": {"min": 1, "max": 0, "increment": -0.5}},
    ],
    "ModelTfPublisher": [{}, {"exclude": ["swivel"]}],
    "OmniDrive": [ON_BASE, {**ON_BASE, **NOISE, **LIMITS}, {**ON_BASE, "odom_drift": [1, 1, 1]}],
    "Pedestrian": [
        {
            "left_leg_body": "left_wheel",
            "right_leg_body": "right_wheel",
            "safety_dist_body": "front_wheel",
        },
        {"radius": 0.3, "speed": 1, "leg_radius": 0.2},
    ],
    "PosePublisher": [{}, {}],
    "RandomWall": [{"layer": "map", "robot_name": "robot"}],
    "TricycleDrive": [
        {**ON_BASE, **WHEELS},
        {**ON_BASE, **WHEELS, **NOISE, **LIMITS},
        {**ON_BASE, **WHEELS, "odom_drift": [1, 1, 1]},
    ],
    "Tween": [{**ON_BASE, "delta": [1, 0, 0]}, {**ON_BASE, "delta": [1, 0, 0], "mode": "trigger"}],
}
"""Sample entries by plugin class, without the keys that every plugin has."""

WORLD: Dict[str, Any] = {
    "properties": {},
    "layers": [{"name": "map", "map": "walls.yaml"}, {"name": "picture", "map": "picture.yaml"}],
    "models": [{"name": "robot", "model": "robot.model.yaml"}],
}
WALLS = ((-9, -9, 9, -9), (9, -9, 9, 9), (9, 9, -9, 9), (-9, 9, -9, -9))


_BASES = {
    each.get("name", ""): each.get("base_class_type", "")
    for each in ElementTree.parse(DECLARATIONS).iter("class")
}


def plugin_names() -> List[str]:
    """The classes that the package declares."""
    return list(_BASES)


def is_of_the_world(name: str) -> bool:
    """True if a plugin's entry is in a world file."""
    return _BASES[name].endswith("WorldPlugin")


def _files() -> WorldFiles:
    files = WorldFiles()
    files.walls("walls", *WALLS)
    files.write("people.csv", "0 1 2 2\n")
    Image.new("L", (4, 4), 255).save(files.folder / "picture.png")
    files.write(
        "picture.yaml",
        "image: picture.png\nresolution: 1\norigin: [0, 0, 0]\noccupied_thresh: 0.5\n",
    )
    return files


def _observed(name: str, entries: Dict[str, Dict[str, Any]]) -> Observation:
    """The getter calls for entries of a plugin, by the plugin's name; each is read by itself."""
    files = _files()
    with observed() as observation:
        for index, (entry_name, sample) in enumerate(entries.items()):
            plugins = [{"type": name, "name": entry_name, **sample}]
            of_world = plugins if is_of_the_world(name) else []
            bodies = TRICYCLE["bodies"][:: -1 if index % 2 else 1]  # another one is the first
            model = {**TRICYCLE, "bodies": bodies, "plugins": [] if of_world else plugins}
            files.write("robot.model.yaml", model)
            files.load({**WORLD, "plugins": of_world}).world.close()
    return observation


def _file_of(name: str) -> str:
    return "world.yaml" if is_of_the_world(name) else "robot.model.yaml"


@lru_cache(maxsize=None)
def keys_of_plugin(name: str) -> List[Key]:
    """The keys of a plugin, but for those that every plugin has."""
    entries = {f"plugin{index}": sample for index, sample in enumerate(PLUGINS[name])}
    keys = _observed(name, entries).keys(_file_of(name), "plugins[]")
    return [key for key in keys if key.name not in ("type", "name", "enabled")]


def defaults_of_plugin(name: str) -> Dict[str, Any]:
    """The defaults of a plugin's keys by their paths, without those in lists of maps."""
    observation = _observed(name, {"plugin": PLUGINS[name][0]})
    return observation.defaults(_file_of(name), "plugins[]")


MAPS: Dict[str, Tuple[str, str]] = {
    "world": ("world.yaml", ""),
    "model": ("robot.model.yaml", ""),
    "image": ("picture.yaml", ""),
    "lines": ("walls.yaml", ""),
}
"""By kind of file: the sample file, and the path in it."""


@lru_cache(maxsize=None)
def keys_of_file(kind: str) -> List[Key]:
    """The keys of a kind of file, but for those of a plugin's own."""
    files = _files()
    plugin = {"type": "DummyModelPlugin", "name": "plugin"}
    world_plugin = {"type": "DummyWorldPlugin", "name": "plugin"}
    bodies = [{**TRICYCLE["bodies"][0], "footprints": [DISC, SQUARE]}, *TRICYCLE["bodies"][1:]]
    files.write("robot.model.yaml", {**TRICYCLE, "bodies": bodies, "plugins": [plugin]})
    with observed() as observation:
        files.load({**WORLD, "plugins": [world_plugin]}).world.close()
    return observation.keys(*MAPS[kind])
