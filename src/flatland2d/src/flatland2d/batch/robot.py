"""The roles of plugins in a batch, and checks that a batch can run a world."""

from typing import List, NamedTuple, Sequence, Tuple

from flatland2d.robot import Robot
from flatland_server import _core
from flatland_server.exceptions import PluginError, UsageError, listed
from flatland_server.models import Model
from flatland_server.plugins import BatchRole
from flatland_server.simulation import World
from flatland_server.transport import LocalTransport


class PluginRole(NamedTuple):
    """A plugin of the world, and its part in the batch."""

    owner: str
    """The name of its model; empty for a plugin of the world."""
    name: str
    type: str
    role: BatchRole


def roles_of(world: World) -> List[PluginRole]:
    """The roles of all plugins of a world, in the order in which a step calls them.

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
    for owner in [*world.models, ""]:
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
            roles.append(PluginRole(owner, plugin.name, plugin.type, role))
    return roles


def make_core(
    world: World,
    robots: Sequence[Robot],
    count: int,
    *,
    threads: int = 1,
    moved: Sequence[Model] = (),
    steps: int = 0,
    varied: Sequence[int] = (),
) -> _core.WorldBatch:
    """A batch of the core.

    Args:
        world: in which environments begin.
        robots: of it, that are commanded and observed.
        count: number of environments.
        threads: number of threads.
        moved: the models that resets can move.
        steps: that the world has made.
        varied: the settings of the core that environments have for themselves.
    """
    return _core.WorldBatch(
        world.physics,
        robots=[
            (
                each.model.physics_bodies,
                each.model.base.config.pose,
                each.core_drive.drive,
                each.core_drive.columns,
                each.core_lidar.lidar,
            )
            for each in robots
        ],
        count=count,
        threads=threads,
        models=[(each.physics_bodies, each.base.config.pose) for each in moved],
        steps=steps,
        varied=varied,
    )


def require_alike(robots: Sequence[Robot]) -> None:
    """Checks that the robots of a batch fit into its arrays, and are described by its facts.

    Raises:
        UsageError: there is none, one is named twice, or their actions or lidars differ.
    """
    names = [robot.model.name for robot in robots]
    if not names or len(set(names)) < len(names):
        raise UsageError(f"expected robots as different names, one at least, found {names}")
    for robot in robots[1:]:
        for fact, a, b in zip(
            ("actions", "limits", "beams", "range"), *map(_facts, (robots[0], robot))
        ):
            if a != b:
                raise UsageError(
                    f"expected robots that are alike: {fact} of {names[0]}: {a}, of "
                    f"{robot.model.name}: {b}"
                )


def _facts(robot: Robot) -> Tuple[object, ...]:
    """The facts that all robots of a batch share."""
    drive, lidar = robot.core_drive, robot.core_lidar
    return robot.action_names, drive.limits, len(lidar.lidar.ranges()), lidar.range


def require_unchanged_footprints(world: World) -> None:
    """Checks that the footprints of a world that was just loaded are those of its files.

    Raises:
        PluginError: a plugin has changed one as it started.
    """
    changed = [name for name, model in world.models.items() if model.footprint_revision]
    if changed:
        raise PluginError(
            f"expected the footprints of the files in a SimulationBatch, found that a plugin has "
            f"changed those of {listed(changed)}: use a Simulation for each environment"
        )
