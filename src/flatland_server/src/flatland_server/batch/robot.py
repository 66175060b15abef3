"""The roles of plugins in a batch, and its robot among the models of a world."""

from typing import Dict, List, NamedTuple, Optional

from flatland_server.exceptions import ModelError, PluginError, listed, shortened, suggestion
from flatland_server.models.model import Model
from flatland_server.plugins.batch_role import BatchRole, CoreDrive, CoreLidar
from flatland_server.plugins.model_plugin import ModelPlugin
from flatland_server.simulation.world import World
from flatland_server.transport.local_transport import LocalTransport


class BatchRobot(NamedTuple):
    """The robot of each environment."""

    model: Model
    drive: ModelPlugin
    core_drive: CoreDrive
    lidar: ModelPlugin
    core_lidar: CoreLidar


class PluginRole(NamedTuple):
    """A plugin of the world, and its part in the batch."""

    owner: str
    """The name of its model; empty for a plugin of the world."""
    name: str
    role: BatchRole


def roles_of(world: World) -> List[PluginRole]:
    """The roles of all plugins of a world.

    Args:
        world: on a LocalTransport.

    Raises:
        PluginError: one has no role, or plugins send messages to others.
    """
    transport = world.transport
    assert isinstance(transport, LocalTransport)
    exchanged = sorted(transport.topics & transport.subscribed)
    if exchanged:
        raise PluginError(
            f"one plugin acts on what another one publishes, on {listed(exchanged)}, and a "
            "SimulationBatch publishes nothing: use a Simulation for each environment"
        )
    roles = []
    for owner in ["", *world.models]:
        for plugin in world.plugins_of(owner).values():
            role = plugin.batch_role
            if role is None:
                raise PluginError(
                    f'the plugin "{plugin.node.owner}" ({plugin.type}) acts in Python while the '
                    "world is loaded or stepped, and a SimulationBatch runs no such plugins: leave "
                    "it out, or use a Simulation for each environment; a class that batches can "
                    "run has a batch_role, declared again where a hook is overridden: BatchRole() "
                    "if its hooks only observe"
                )
            roles.append(PluginRole(owner, plugin.name, role))
    return roles


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
        drives[owner] = [each for each in plugins if _role(each).drive]
        lidars[owner] = [each for each in plugins if _role(each).lidar]
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
    core_drive, core_lidar = _role(drive).drive, _role(chosen).lidar
    assert core_drive is not None
    assert core_lidar is not None
    return BatchRobot(model, drive, core_drive, chosen, core_lidar)


def _role(plugin: ModelPlugin) -> BatchRole:
    return plugin.batch_role or BatchRole()


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
