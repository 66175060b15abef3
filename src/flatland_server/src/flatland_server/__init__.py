"""Flatland's server: worlds in YAML, moved by Box2D, with robots made of plugins.

The names exported here are the public interface for plugins; programs that step a world import from
`flatland2d`:

    from flatland_server import ModelPlugin, Timekeeper, YamlReader

Modules below are implementation: they may change. Everything but `flatland_server.ros` works
without a ROS master.
"""

import importlib as _importlib
import pkgutil as _pkgutil

# The extension module is in catkin's devel space. A process that multiprocessing spawns has this
# folder before it in sys.path, since the package there has put it there.
__path__ = _pkgutil.extend_path(__path__, __name__)

try:
    _importlib.import_module("flatland_server._core")
except ImportError as _error:
    _cause = _importlib.import_module("flatland_server.wrong_python")
    raise _cause.wrong_python(_error) from None

from flatland_server import messages
from flatland_server._core import (
    EASINGS,
    TWEEN_MODES,
    Ackermann,
    BeamFan,
    Body,
    BodyMessage,
    Contact,
    ContactImpulse,
    Crowd,
    Drift,
    Drive,
    Fixture,
    GoneError,
    Lidar,
    Manifold,
    RangeNoise,
    RelativePoses,
    StepMessage,
    Tricycle,
    Tween,
)
from flatland_server._core import __version__ as __version__
from flatland_server.array_math import cos_sin, from_segments, headings
from flatland_server.arrays import BoolArray, Float32Array, FloatArray, IntArray, PoseLike, Segments
from flatland_server.canvas import Canvas
from flatland_server.config.input_files import read_input
from flatland_server.config.yaml_map import check_topic_name
from flatland_server.config.yaml_reader import REQUIRED, Color, YamlReader
from flatland_server.exceptions import (
    FlatlandError,
    LayerError,
    MessageError,
    MissingPackageError,
    ModelError,
    PluginError,
    Problem,
    RecordingError,
    StateError,
    TopicError,
    UsageError,
    YamlError,
)
from flatland_server.geometry import Point, Pose, Transform, Velocity, quaternion, wrap_angle
from flatland_server.messages.conversions import (
    fill_pose,
    fill_twist,
    header,
    ros_time,
    stamp_of,
    yaw_of,
)
from flatland_server.models.collision_filter_registry import CollisionFilterRegistry
from flatland_server.models.entity import Entity
from flatland_server.models.footprint import Circle, Footprint, Polygon
from flatland_server.models.joint import Joint
from flatland_server.models.layer import Layer
from flatland_server.models.model import Model, ModelConfig
from flatland_server.models.model_body import BodyConfig, ModelBody
from flatland_server.plugins.batch_role import BatchMotion, BatchRole, CoreDrive, CoreLidar
from flatland_server.plugins.model_plugin import ContactSides, ModelPlugin
from flatland_server.plugins.plugin_loader import PluginDeclaration, PluginLoader
from flatland_server.simulation.world import World, WorldPlugin
from flatland_server.simulation.world_config import ModelEntry, WorldConfig
from flatland_server.timekeeper import Timekeeper
from flatland_server.transport.local_transport import LocalTransport
from flatland_server.transport.node import Node
from flatland_server.transport.transport import Frames, MessageWriter, Publisher, Subscription
from flatland_server.update_timer import UpdateTimer

__all__ = [
    "EASINGS",
    "REQUIRED",
    "TWEEN_MODES",
    "Ackermann",
    "BatchMotion",
    "BatchRole",
    "BeamFan",
    "Body",
    "BodyConfig",
    "BodyMessage",
    "BoolArray",
    "Canvas",
    "Circle",
    "CollisionFilterRegistry",
    "Color",
    "Contact",
    "ContactImpulse",
    "ContactSides",
    "CoreDrive",
    "CoreLidar",
    "Crowd",
    "Drift",
    "Drive",
    "Entity",
    "Fixture",
    "FlatlandError",
    "Float32Array",
    "FloatArray",
    "Footprint",
    "Frames",
    "GoneError",
    "IntArray",
    "Joint",
    "Layer",
    "LayerError",
    "Lidar",
    "LocalTransport",
    "Manifold",
    "MessageError",
    "MessageWriter",
    "MissingPackageError",
    "Model",
    "ModelBody",
    "ModelConfig",
    "ModelEntry",
    "ModelError",
    "ModelPlugin",
    "Node",
    "PluginDeclaration",
    "PluginError",
    "PluginLoader",
    "Point",
    "Polygon",
    "Pose",
    "PoseLike",
    "Problem",
    "Publisher",
    "RangeNoise",
    "RecordingError",
    "RelativePoses",
    "Segments",
    "StateError",
    "StepMessage",
    "Subscription",
    "Timekeeper",
    "TopicError",
    "Transform",
    "Tricycle",
    "Tween",
    "UpdateTimer",
    "UsageError",
    "Velocity",
    "World",
    "WorldConfig",
    "WorldPlugin",
    "YamlError",
    "YamlReader",
    "check_topic_name",
    "cos_sin",
    "fill_pose",
    "fill_twist",
    "from_segments",
    "header",
    "headings",
    "messages",
    "quaternion",
    "read_input",
    "ros_time",
    "stamp_of",
    "wrap_angle",
    "yaw_of",
]
