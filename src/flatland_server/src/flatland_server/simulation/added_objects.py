"""Models and walls added to a world since it was made from its files, for saved states."""

from typing import Dict, List, Mapping, Optional

from flatland_server.arrays import Segments
from flatland_server.exceptions import StateError
from flatland_server.models.model import Model
from flatland_server.simulation.world_config import ModelEntry
from flatland_server.simulation.world_state import ModelState, WallsState


class AddedObjects:
    """Models and walls in the order in which they were added.

    Rebuilding the world or a plugin brings back those that come with the world or that plugins add
    in `on_initialize`. Such walls are not recorded, such models only because they may be deleted.

    Attributes:
        entries: by name, those of all models of the world, with the poses at which they were added.
        walls: the added walls.
    """

    def __init__(self) -> None:
        self._count = 0
        self.entries: Dict[str, ModelEntry] = {}
        self._orders: Dict[str, Optional[int]] = {}
        self.walls: List[WallsState] = []

    def add_model(self, entry: ModelEntry, comes_with_another: bool) -> None:
        """Records a model.

        Args:
            entry: the model's entry.
            comes_with_another: whether a rebuild of the world or of another model adds it again.
        """
        self._count += 1
        self.entries[entry.name] = entry
        self._orders[entry.name] = None if comes_with_another else self._count

    def remove_model(self, name: str) -> None:
        """Removes the record of a model."""
        self.entries.pop(name, None)
        self._orders.pop(name, None)

    def add_walls(self, layer: int, segments: Segments) -> None:
        """Records walls of a layer that no rebuild of the world or of a model adds again."""
        self._count += 1
        self.walls.append(WallsState(self._count, layer, segments.copy()))

    def states_of(self, models: Mapping[str, Model]) -> List[ModelState]:
        """The states of the models that exist, in the order in which they were added.

        Args:
            models: models of the world, by name.

        Raises:
            StateError: one of them has no file that it could be read from again.
        """
        states = []
        for name, entry in self.entries.items():
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
                    dict(content) if isinstance(content, Mapping) else content,
                )
            )
        return states
