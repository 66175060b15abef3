"""Plugins: their base classes, and how they are found, made, scheduled and called."""

from flatland_server.plugins.batch_role import (
    AddNoise,
    BatchMotion,
    BatchRole,
    CoreDrive,
    CoreLidar,
)
from flatland_server.plugins.model_plugin import ModelPlugin
from flatland_server.plugins.plugin import Plugin, plugin_label
from flatland_server.plugins.plugin_loader import PluginLoader, shared_loader
from flatland_server.plugins.plugin_rng import plugin_rng

__all__ = [
    "AddNoise",
    "BatchMotion",
    "BatchRole",
    "CoreDrive",
    "CoreLidar",
    "ModelPlugin",
    "Plugin",
    "PluginLoader",
    "plugin_label",
    "plugin_rng",
    "shared_loader",
]
