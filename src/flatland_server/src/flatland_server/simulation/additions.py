"""What has been added to a world since it was made from its files, for saved states."""

from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Dict, List, Mapping, Optional, Union

from flatland_server.arrays import Segments
from flatland_server.exceptions import StateError
from flatland_server.geometry import Pose
from flatland_server.models.model import Model
from flatland_server.simulation.world_config import ModelEntry, WorldConfig
from flatland_server.simulation.world_state import ModelState, WallsState, WorldState

if TYPE_CHECKING:
    from flatland_server.simulation.world import World


class Additions:
    """Models and walls in the order in which they were added.

    Those that come with the world, or that plugins add in `on_initialize`, are not additions:
    rebuilding the world or the plugin brings them back. Models are noted nevertheless, so that it
    is known which of them exist.
    """

    def __init__(self) -> None:
        self._count = 0
        self._entries: Dict[str, ModelEntry] = {}
        self._orders: Dict[str, Optional[int]] = {}
        self.walls: List[WallsState] = []

    def add_model(self, entry: ModelEntry, comes_with_another: bool) -> None:
        """Notes a model.

        Args:
            entry: what it was made from.
            comes_with_another: whether making the world or another model makes this one, too.
        """
        self._count += 1
        self._entries[entry.name] = entry
        self._orders[entry.name] = None if comes_with_another else self._count

    def remove_model(self, name: str) -> None:
        """Notes that a model is gone."""
        self._entries.pop(name, None)
        self._orders.pop(name, None)

    def add_walls(self, layer: int, segments: Segments) -> None:
        """Notes walls of a layer, which do not come with the world or a model."""
        self._count += 1
        self.walls.append(WallsState(self._count, layer, segments.copy()))

    def states_of(self, models: Mapping[str, Model]) -> List[ModelState]:
        """The states of the models that exist, in the order in which they were added.

        Args:
            models: those of the world, by name.

        Raises:
            StateError: one of them has no file that it could be read from again.
        """
        states = []
        for name, entry in self._entries.items():
            order = self._orders[name]
            if order is not None and not entry.model.is_read:
                raise StateError(f'the model "{name}" was made by a program, without a file')
            path = str(entry.model.path.absolute())
            content = entry.model.content
            states.append(
                ModelState(
                    name,
                    order,
                    entry.namespace,
                    path,
                    list(entry.pose),
                    models[name].move_revision,
                    dict(content) if content is not None else None,
                )
            )
        return states


def wall_counts(config: WorldConfig) -> Dict[str, int]:
    """The number of walls of each layer in the world's files."""
    return {layer.names[0]: len(config.walls_of(layer)) for layer in config.layers}


def check_walls(state: WorldState, config: WorldConfig) -> None:
    """Checks that a state is of a world with these maps.

    Raises:
        StateError: it is not.
    """
    expected, found = wall_counts(config), state.wall_counts
    for layer in dict.fromkeys([*expected, *found]):
        if expected.get(layer) != found.get(layer):
            raise StateError(
                f'the state is of another world ({state.world}): the layer "{layer}" has '
                f"{found.get(layer, 'no')} walls there, {expected.get(layer, 'no')} here"
            )


def replay(state: WorldState, world: "World") -> None:
    """Deletes and adds models and walls of a rebuilt world, until it has those of a state.

    Raises:
        FlatlandError: a file is missing, or the state is of another world.
    """
    kept = {model.name for model in state.models if model.order is None}
    for name in [name for name in world.models if name not in kept]:
        world.delete_model(name)
    additions: List[Union[ModelState, WallsState]] = [*state.walls]
    additions += [model for model in state.models if model.order is not None]
    for addition in sorted(additions, key=attrgetter("order")):
        if isinstance(addition, ModelState):
            source = addition.content if addition.content is not None else Path(addition.path)
            pose = Pose(*addition.pose)
            world.spawn_model(source, addition.name, addition.namespace, pose)
        elif 0 <= addition.layer < len(world.layers):
            world.add_walls(world.layers[addition.layer].name, addition.segments)
    if list(world.models) != [model.name for model in state.models]:
        raise StateError(
            f"the state is of another world: expected the models {', '.join(world.models)}; "
            f"found {', '.join(model.name for model in state.models)}"
        )
    for model in state.models:
        world.models[model.name].move_revision = model.move_revision
