"""The world, its steps, and the loop that runs it in real time."""

from flatland_server.simulation.history import RunWithHistory
from flatland_server.simulation.pacer import WallTimekeeper
from flatland_server.simulation.plugin_state import PluginState
from flatland_server.simulation.simulation_manager import SimulationManager
from flatland_server.simulation.slow_plugin_watch import SlowPluginWatch
from flatland_server.simulation.thread_priority import ThreadPriority
from flatland_server.simulation.world import World
from flatland_server.simulation.world_config import ModelEntry, WorldConfig
from flatland_server.simulation.world_state import WorldState

__all__ = [
    "ModelEntry",
    "PluginState",
    "RunWithHistory",
    "SimulationManager",
    "SlowPluginWatch",
    "ThreadPriority",
    "WallTimekeeper",
    "World",
    "WorldConfig",
    "WorldState",
]
