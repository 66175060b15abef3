"""Finds the robot of a batch among the models of a world, and checks that a batch can run it."""

from typing import Dict, List, NamedTuple, Optional

from flatland_server.exceptions import ModelError, PluginError, listed, shortened, suggestion
from flatland_server.models.model import Model
from flatland_server.plugins.core_parts import CoreDrive, CoreLidar
from flatland_server.plugins.model_plugin import ModelPlugin
from flatland_server.plugins.plugin import HOOKS, Plugin
from flatland_server.simulation.world import World
from flatland_server.transport.local_transport import LocalTransport


class BatchRobot(NamedTuple):
    """The robot of each environment."""

    model: Model
    drive: ModelPlugin
    core_drive: CoreDrive
    lidar: ModelPlugin
    core_lidar: CoreLidar


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


def find_robot(world: World, name: Optional[str], lidar: Optional[str]) -> BatchRobot:
    """The model with a drive and a lidar.

    Args:
        world: that has it.
        name: of the model; None: the only one.
        lidar: name of its plugin; None: the only one.

    Raises:
        ModelError: there is no such model or lidar, or there are several ones.
    """
    drives: Dict[str, List[ModelPlugin]] = {}
    lidars: Dict[str, List[ModelPlugin]] = {}
    for owner in world.models:
        plugins = [
            each for each in world.plugins_of(owner).values() if isinstance(each, ModelPlugin)
        ]
        drives[owner] = [each for each in plugins if each.core_drive is not None]
        lidars[owner] = [each for each in plugins if each.core_lidar is not None]
    if name is None:
        robots = [owner for owner in world.models if drives[owner] and lidars[owner]]
        if not robots:
            found = [f"{each} ({_missing(drives[each], lidars[each])})" for each in world.models]
            raise ModelError(f"expected a model with a drive and a lidar, found {listed(found)}")
        if len(robots) > 1:
            raise ModelError(f"expected one robot, found {listed(robots)}: say which (robot=...)")
        name = robots[0]
    model = world.get_model(name)
    if len(drives[name]) != 1:
        found_drives = listed([each.name for each in drives[name]])
        raise ModelError(f'expected a model with one drive, "{name}" has: {found_drives}')
    chosen = _choose(name, lidars[name], lidar)
    drive = drives[name][0]
    assert drive.core_drive is not None
    assert chosen.core_lidar is not None
    return BatchRobot(model, drive, drive.core_drive, chosen, chosen.core_lidar)


def _missing(drives: List[ModelPlugin], lidars: List[ModelPlugin]) -> str:
    """What a model lacks that would make it a robot."""
    if drives:
        return "no lidar"
    return "no drive" if lidars else "neither"


def _choose(model: str, lidars: List[ModelPlugin], name: Optional[str]) -> ModelPlugin:
    names = [each.name for each in lidars]
    if name is None:
        if len(lidars) != 1:
            say_which = ": say which (lidar=...)" if lidars else ""
            raise ModelError(
                f'expected a model with one lidar, "{model}" has: {listed(names)}{say_which}'
            )
        return lidars[0]
    for each in lidars:
        if each.name == name:
            return each
    hint = suggestion(name, names)
    raise ModelError(
        f'the model "{model}" has no lidar "{shortened(name)}"{hint}; it has: {listed(names)}'
    )
