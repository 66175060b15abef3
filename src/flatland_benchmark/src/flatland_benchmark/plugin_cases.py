"""The cost of each built-in plugin in a step: idle, due without and with subscribers."""

import math
import time
from pathlib import Path
from typing import Any, Dict, Mapping, Sequence

from flatland2d import Simulation
from flatland_benchmark.case import Figures, case

_STEPS = 100
"""Steps in a call."""
_CALLS = 20
"""Calls in a block; a figure is the least of the blocks."""
_BLOCKS = 30

_BODY = {"body": "base"}
_DRIFT = {"odom_drift": {"rotation_per_radian": 0.01}}
_LAG = {"actuators": {"linear": {"delay": 0.1, "time_constant": 0.1}}}
_TRACTION = {"actuators": {"traction": {"friction": 0.7}}}
_CAR = {"wheelbase": 0.3, "max_steer_angle": 0.8, **_BODY}
_SLIP = {
    **{"mass": 4, "inertia": 0.05, "center_of_mass": 0.15, "friction": 1},
    **{"front_stiffness": 5, "rear_stiffness": 5},
}
_PLUGINS: Dict[str, Dict[str, Any]] = {
    "DiffDrive": _BODY,
    "DiffDrive with drift": {"type": "DiffDrive", **_DRIFT, **_BODY},
    "DiffDrive with lag": {"type": "DiffDrive", **_LAG, **_BODY},
    "DiffDrive with traction": {"type": "DiffDrive", **_TRACTION, **_BODY},
    "OmniDrive": _BODY,
    "TricycleDrive": {
        "front_wheel_joint": "front",
        "rear_left_wheel_joint": "left",
        "rear_right_wheel_joint": "right",
        **_BODY,
    },
    "AckermannDrive": _CAR,
    "AckermannDrive with slip": {"type": "AckermannDrive", "single_track": _SLIP, **_CAR},
    "Tween": {"delta": [1, 0, 0], **_BODY},
    "Laser": {"range": 8, "angle": {"min": -2, "max": 2, "increment": 0.0125}, **_BODY},
    "Imu": _BODY,
    "Gps": {"update_rate": math.inf, **_BODY},
    "PosePublisher": {"update_rate": math.inf, **_BODY},
    "ModelTfPublisher": {},
    "Bumper": {},
    "BoolSensor": _BODY,
    "Pedestrian": {"goals": [[0.6, 0], [-0.6, 0]], **_BODY},
}
"""The keys of plugins that are due at each step, by the names of their figures."""

_WORLD_PLUGINS: Dict[str, Dict[str, Any]] = {
    "Crowd of two": {
        "type": "Crowd",
        "pedestrians": [{"pose": [x, 0.4, 0], "goals": [[1.2, 0.4], [-1.2, 0.4]]} for x in (1, -1)],
    },
    "RandomWall": {"layer": "map", "robot_name": "robot", "num_of_walls": 3},
}
"""The same for plugins of the world."""


@case("plugins", "what each plugin adds to a robot's step")
def measure_plugins(worlds: Path) -> Figures:
    """Processor time that each plugin adds to a step of a robot that turns on the spot."""
    figures = {}
    for name, keys in [*_PLUGINS.items(), *_WORLD_PLUGINS.items()]:
        plugin = {"type": name, "name": "plugin", **keys}
        parts: Sequence[Dict[str, Any]] = ({}, plugin, plugin)
        if name in _WORLD_PLUGINS:
            robots = [_spinning_robot(worlds, world_plugin=each) for each in parts]
        else:
            robots = [_spinning_robot(worlds, each, rolls="Tricycle" in name) for each in parts]
        with robots[0] as bare, robots[1] as idle, robots[2] as heard:
            heard.subscribe(*heard.topics, "/tf")
            times: Dict[Simulation, float] = {}
            for _ in range(_BLOCKS):
                for sim in (bare, idle, heard):
                    times[sim] = min(times.get(sim, 1.0), _time_step(sim))
        figures[f"{name} idle [us]"] = (times[idle] - times[bare]) * 1e6
        figures[f"{name} heard [us]"] = (times[heard] - times[bare]) * 1e6
    return figures


def _spinning_robot(
    worlds: Path,
    plugin: Mapping[str, Any] = {},
    world_plugin: Mapping[str, Any] = {},
    *,
    rolls: bool = False,
) -> Simulation:
    """The office with a robot that turns on the spot, with or without plugins and wheels."""
    wheels = _WHEELS if rolls else {}
    robot = {
        "bodies": [_disc("base", 0.2), *(_disc(name, 0.05) for name in wheels)],
        "joints": [_joint(name, *wheel) for name, wheel in wheels.items()],
        "plugins": [plugin] if plugin else [],
    }
    sim = Simulation(
        {
            "properties": {},
            "layers": [{"name": "map", "map": str(worlds / "office" / "office.yaml")}],
            "models": [{"name": "robot", "model": robot}],
            "plugins": [world_plugin] if world_plugin else [],
        }
    )
    handle = sim.models["robot"]
    handle.model.base.physics_body.velocity = (0.0, 0.0, 0.5)
    if len(handle.drives):
        handle.command(*_COMMANDS.get(plugin["type"], (0.0, 0.5)))
    sim.step(_STEPS)
    return sim


_COMMANDS = {"OmniDrive": (0.0, 0.0, 0.5), "TricycleDrive": (0.15, math.pi / 2)}
_COMMANDS["AckermannDrive"] = (0.2, math.atan(0.75))
"""Of drives that are not told (speed, yaw rate): each turns by 0.5 rad/s."""

_WHEELS = {
    "front": ("revolute", [0.0, 0.0]),
    "left": ("weld", [-0.3, 0.2]),
    "right": ("weld", [-0.3, -0.2]),
}


def _disc(name: str, radius: float) -> Dict[str, Any]:
    return {"name": name, "footprints": [{"type": "circle", "radius": radius, "density": 1}]}


def _joint(name: str, type: str, anchor: Sequence[float]) -> Dict[str, Any]:
    ends = [{"name": "base", "anchor": anchor}, {"name": name, "anchor": [0, 0]}]
    return {"name": name, "type": type, "bodies": ends}


def _time_step(sim: Simulation) -> float:
    begin = time.process_time()
    for _ in range(_CALLS):
        sim.step(_STEPS)
    return (time.process_time() - begin) / (_CALLS * _STEPS)
