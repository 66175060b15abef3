"""Checks that a batch can run the plugins of a world."""

from flatland_server.exceptions import PluginError, listed
from flatland_server.plugins.plugin import HOOKS, Plugin
from flatland_server.simulation.world import World
from flatland_server.transport.local_transport import LocalTransport


def require_passive(world: World) -> None:
    """Checks that a batch can run a world.

    Args:
        world: on a LocalTransport.

    Raises:
        PluginError: it has a plugin that acts by itself, or plugins that send messages to others.
    """
    transport = world.transport
    assert isinstance(transport, LocalTransport)
    exchanged = sorted(transport.topics & transport.subscribed)
    if exchanged:
        raise PluginError(
            f"one plugin acts on what another one publishes, on {listed(exchanged)}, and a "
            "SimulationBatch publishes nothing: use a Simulation for each environment"
        )
    for owner in ["", *world.models]:
        for plugin in world.plugins_of(owner).values():
            if not (is_passive(plugin) or acts_when_loaded(plugin) or has_batch_motion(plugin)):
                label = f"{owner}/{plugin.name}" if owner else plugin.name
                raise PluginError(
                    f'the plugin "{label}" ({plugin.type}) acts in Python while the world is '
                    "loaded or stepped, and a SimulationBatch runs no such plugins: leave it out, "
                    "or use a Simulation for each environment; the class of a plugin that only "
                    "observes says so with is_passive = True"
                )


def is_passive(plugin: Plugin) -> bool:
    """Whether the plugin's class says so, after the last one that overrides a hook."""
    return plugin.is_passive and _knows_all_hooks(plugin, "is_passive")


def acts_when_loaded(plugin: Plugin) -> bool:
    """Whether the plugin's class says that its hooks change nothing, but its start does."""
    return plugin.acts_when_loaded and _knows_all_hooks(plugin, "acts_when_loaded")


def has_batch_motion(plugin: Plugin) -> bool:
    """Whether the plugin's class says what it does in a batch, after overriding hooks."""
    return _knows_all_hooks(plugin, "make_batch_motion")


def _knows_all_hooks(plugin: Plugin, name: str) -> bool:
    """Whether an attribute was set by the last class that overrides a hook, or after it."""
    for each in type(plugin).__mro__:
        if each is Plugin:
            break
        if name in vars(each):
            return True
        if any(hook in vars(each) for hook in HOOKS):
            break
    return False
