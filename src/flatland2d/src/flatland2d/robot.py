"""Finds the robot of a world: its model, its drive and its lidar."""

import inspect
from typing import Dict, List, Mapping, NamedTuple, Optional, Tuple

from flatland_server import _core
from flatland_server.exceptions import ModelError, listed, unknown
from flatland_server.models import Model
from flatland_server.plugins import BatchRole, CoreDrive, CoreLidar, ModelPlugin, Plugin
from flatland_server.simulation import World


class Robot(NamedTuple):
    """A model with a drive and a lidar of the core."""

    model: Model
    drive: ModelPlugin
    core_drive: CoreDrive
    lidar: ModelPlugin
    core_lidar: CoreLidar

    @property
    def action_names(self) -> Tuple[str, ...]:
        """The parameters of the drive's `command`."""
        return tuple(inspect.signature(self.drive.command).parameters)

    @property
    def is_steered(self) -> bool:
        """True if its drive is a tricycle or a car: a command is a speed and a steering angle."""
        return isinstance(self.core_drive.drive, (_core.Tricycle, _core.Ackermann))


def plugins_with(plugins: Mapping[str, Plugin], hook: str) -> List[str]:
    """The names of the plugins that override a method of `ModelPlugin`, in their order.

    Args:
        plugins: by name.
        hook: "command" for drives, "read" for sensors.
    """
    original = getattr(ModelPlugin, hook)
    return [name for name, each in plugins.items() if getattr(type(each), hook) is not original]


def driven_models(world: World) -> List[str]:
    """The names of the models with a drive."""
    return [name for name in world.models if plugins_with(world.plugins_of(name), "command")]


def find_robot(world: World, name: Optional[str] = None, lidar: Optional[str] = None) -> Robot:
    """The model with a drive and a lidar.

    Args:
        world: world to look in.
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
    if name not in drives:
        raise ModelError(unknown("there is no model", name, drives))
    model = world.get_model(name)
    if len(drives[name]) != 1:
        found_drives = listed([each.name for each in drives[name]])
        raise ModelError(f'expected a model with one drive, "{name}" has: {found_drives}')
    chosen = _choose(name, lidars[name], lidar)
    drive = drives[name][0]
    core_drive, core_lidar = _role(drive).drive, _role(chosen).lidar
    assert core_drive is not None
    assert core_lidar is not None
    return Robot(model, drive, core_drive, chosen, core_lidar)


def _role(plugin: ModelPlugin) -> BatchRole:
    return plugin.batch_role or BatchRole()


def _missing(drives: List[ModelPlugin], lidars: List[ModelPlugin]) -> str:
    """The parts that a model lacks to be a robot."""
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
    raise ModelError(unknown(f'the model "{model}" has no lidar', name, names, "it has"))
