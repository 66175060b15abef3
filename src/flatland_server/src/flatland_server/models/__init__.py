"""The parts of a world: layers, and models with their bodies, footprints and joints."""

from flatland_server.models.collision_filter_registry import AnyLayer, CollisionFilterRegistry
from flatland_server.models.entity import Entity
from flatland_server.models.footprint import Circle
from flatland_server.models.joint import JointConfig
from flatland_server.models.layer import Layer, LayerConfig
from flatland_server.models.model import Model, ModelConfig
from flatland_server.models.model_body import BodyConfig, ModelBody
from flatland_server.models.plugin_config import PluginConfig

__all__ = [
    "AnyLayer",
    "BodyConfig",
    "Circle",
    "CollisionFilterRegistry",
    "Entity",
    "JointConfig",
    "Layer",
    "LayerConfig",
    "Model",
    "ModelBody",
    "ModelConfig",
    "PluginConfig",
]
