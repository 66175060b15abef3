"""Plugins: their base classes, and how they are found, made, scheduled and called."""

from flatland_server.plugins.batch_role import (
    AddNoise,
    BatchMotion,
    BatchRole,
    CoreDrive,
    CoreLidar,
)
from flatland_server.plugins.model_plugin import ModelPlugin
from flatland_server.plugins.plugin import Plugin
from flatland_server.plugins.plugin_loader import PluginLoader
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
    "plugin_rng",
]
