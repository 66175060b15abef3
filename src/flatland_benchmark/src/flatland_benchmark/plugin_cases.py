"""The cost of each built-in plugin in a step: without subscribers, and with one on each topic."""

import math
import time
from pathlib import Path
from typing import Any, Dict

from flatland2d import Simulation
from flatland_benchmark.case import Case, Figures

_STEPS = 100
"""Steps in a call."""
_CALLS = 20
"""Calls in a block; a figure is the least of the blocks."""
_BLOCKS = 30

_BODY = {"body": "base"}
_PLUGINS: Dict[str, Dict[str, Any]] = {
    "DiffDrive": _BODY,
    "DiffDrive with drift": {
        "type": "DiffDrive",
        "odom_drift": {"rotation_per_radian": 0.01},
        **_BODY,
    },
    "Tween": {"delta": [1, 0, 0], **_BODY},
    "Laser": {"range": 8, "angle": {"min": -2, "max": 2, "increment": 0.0125}, **_BODY},
    "Imu": _BODY,
    "Gps": {"update_rate": math.inf, **_BODY},
    "PosePublisher": {"update_rate": math.inf, **_BODY},
    "ModelTfPublisher": {},
    "Bumper": {},
    "BoolSensor": _BODY,
}
"""The keys of plugins that are due at each step, by the names of their figures."""


def measure_plugins(worlds: Path) -> Figures:
    """Processor time that each plugin adds to a step of a robot that turns on the spot."""
    figures = {}
    for name, keys in _PLUGINS.items():
        plugin = {"type": name, "name": "plugin", **keys}
        robots = (_spinning_robot(worlds), *(_spinning_robot(worlds, plugin) for _ in range(2)))
        with robots[0] as bare, robots[1] as idle, robots[2] as heard:
            heard.subscribe(*heard.topics, "/tf")
            times: Dict[Simulation, float] = {}
            for _ in range(_BLOCKS):
                for sim in (bare, idle, heard):
                    times[sim] = min(times.get(sim, 1.0), _time_step(sim))
        figures[f"{name} idle [us]"] = (times[idle] - times[bare]) * 1e6
        figures[f"{name} heard [us]"] = (times[heard] - times[bare]) * 1e6
    return figures


def _spinning_robot(worlds: Path, *plugins: Dict[str, Any]) -> Simulation:
    """The office with a robot that has these plugins, and turns on the spot."""
    disc = {"type": "circle", "radius": 0.2, "density": 1}
    robot = {"bodies": [{"name": "base", "footprints": [disc]}], "plugins": list(plugins)}
    layer = {"name": "map", "map": str(worlds / "office" / "office.yaml")}
    sim = Simulation({"properties": {}, "layers": [layer]})
    handle = sim.spawn(robot, "robot")
    handle.model.base.physics_body.velocity = (0.0, 0.0, 0.5)
    if len(handle.drives):
        handle.command(0.0, 0.5)
    sim.step(_STEPS)
    return sim


def _time_step(sim: Simulation) -> float:
    begin = time.process_time()
    for _ in range(_CALLS):
        sim.step(_STEPS)
    return (time.process_time() - begin) / (_CALLS * _STEPS)


PLUGIN_CASES = (Case("plugins", "what each plugin adds to a robot's step", measure_plugins),)
