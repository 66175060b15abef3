"""Flatland as a library: worlds stepped by a program, alone or thousands in one call, without ROS.

The names exported here are what a program needs:

    from flatland2d import Simulation

Plugins import from `flatland_server`, the simulator itself. `flatland2d.sweep` has the type of a
sweep's runs. Other modules are implementation: they may change.
"""

import importlib as _importlib
import typing as _typing

import flatland_server as _flatland_server  # noqa: F401 (first: it tells of a wrong Python)
from flatland2d.batch.observation import BatchObservation
from flatland2d.free_space import DistanceGrid, FreeSpace
from flatland2d.handles import DriveHandle, ModelHandle, SensorHandle
from flatland2d.robot import find_robot
from flatland2d.simulation import Simulation
from flatland2d.touch import Touch
from flatland2d.world_source import world_content
from flatland_server import (
    FlatlandError,
    Float32Array,
    FloatArray,
    LayerError,
    MessageError,
    MissingPackageError,
    ModelError,
    PluginDeclaration,
    PluginError,
    PluginLoader,
    Point,
    Pose,
    Problem,
    RecordingError,
    StateError,
    TopicError,
    UsageError,
    Velocity,
    YamlError,
    messages,
)
from flatland_server import __version__ as __version__
from flatland_server._core import Walls

if _typing.TYPE_CHECKING:
    from flatland2d.batch.simulation_batch import SimulationBatch
    from flatland2d.picture_page import PicturePage
    from flatland2d.recorder import Recorder
    from flatland2d.rendering.film import Animation

_LATER = {
    "Animation": "flatland2d.rendering.film",
    "PicturePage": "flatland2d.picture_page",
    "Recorder": "flatland2d.recorder",
    "SimulationBatch": "flatland2d.batch.simulation_batch",
}
"""Names that are imported when they are first used, and their modules."""


def __getattr__(name: str) -> _typing.Any:
    if name not in _LATER:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = globals()[name] = getattr(_importlib.import_module(_LATER[name]), name)
    return value


__all__ = [
    "Animation",
    "BatchObservation",
    "DistanceGrid",
    "DriveHandle",
    "FlatlandError",
    "Float32Array",
    "FloatArray",
    "FreeSpace",
    "LayerError",
    "MessageError",
    "MissingPackageError",
    "ModelError",
    "ModelHandle",
    "PicturePage",
    "PluginDeclaration",
    "PluginError",
    "PluginLoader",
    "Point",
    "Pose",
    "Problem",
    "Recorder",
    "RecordingError",
    "SensorHandle",
    "Simulation",
    "SimulationBatch",
    "StateError",
    "TopicError",
    "Touch",
    "UsageError",
    "Velocity",
    "Walls",
    "YamlError",
    "find_robot",
    "messages",
    "world_content",
]
