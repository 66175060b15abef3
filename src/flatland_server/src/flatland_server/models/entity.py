"""Entities: the models and layers of a world, which own its bodies."""

from abc import ABC, abstractmethod
from typing import Dict, Iterable, Iterator, List, Optional

from flatland_server import _core


class Entity(ABC):
    """A model or a layer: what a plugin is told that it is in contact with."""

    @property
    @abstractmethod
    def name(self) -> str:
        """The name of the model, or the first name of the layer."""

    @property
    @abstractmethod
    def physics_bodies(self) -> List[_core.Body]:
        """Its bodies in the physical world."""

    @abstractmethod
    def body_name(self, fixture: _core.Fixture) -> str:
        """The name of the body of a fixture of this entity; for a layer, the name of the layer."""


class Entities:
    """The entities of a world, by the bodies that they own."""

    def __init__(self) -> None:
        self._owners: Dict[int, Entity] = {}

    def add(self, entity: Entity, bodies: Iterable[_core.Body]) -> None:
        """Registers an entity as the owner of bodies."""
        self._owners.update((body.id, entity) for body in bodies)

    def remove(self, bodies: Iterable[_core.Body]) -> None:
        """Unregisters bodies."""
        for body in bodies:
            self._owners.pop(body.id, None)

    def owner(self, body_id: int) -> Entity:
        """The entity that owns the body with this `id`.

        Raises:
            GoneError: the body has been deleted, or belongs to no model or layer.
        """
        owner = self.find(body_id)
        if owner is None:
            raise _core.GoneError("this body has been deleted, or belongs to no model or layer")
        return owner

    def find(self, body_id: int) -> Optional[Entity]:
        """The same, or None if it has no owner, such as a body that a plugin has created."""
        return self._owners.get(body_id)

    def __iter__(self) -> Iterator[Entity]:
        return iter(dict.fromkeys(self._owners.values()))
