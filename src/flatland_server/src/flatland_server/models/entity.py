"""Entities: what bodies belong to, a model or a layer."""

from abc import ABC, abstractmethod
from typing import Dict, Iterable, Iterator, List, Optional

from flatland_server import _core


class Entity(ABC):
    """A model or a layer, as contacts have to do with it."""

    @property
    @abstractmethod
    def name(self) -> str:
        """The model's name, or the first of the layer's."""

    @property
    @abstractmethod
    def physics_bodies(self) -> List[_core.Body]:
        """Its bodies in the core."""

    @abstractmethod
    def body_name(self, fixture: _core.Fixture) -> str:
        """The name of the body that a fixture of this entity belongs to; a layer's is its own."""


class Entities:
    """Which entity a body belongs to."""

    def __init__(self) -> None:
        self._owners: Dict[int, Entity] = {}

    def add(self, entity: Entity, bodies: Iterable[_core.Body]) -> None:
        """Notes whose these bodies are."""
        self._owners.update((body.id, entity) for body in bodies)

    def remove(self, bodies: Iterable[_core.Body]) -> None:
        """Forgets bodies that are gone."""
        for body in bodies:
            self._owners.pop(body.id, None)

    def owner(self, body_id: int) -> Entity:
        """Whose the body of this `id` is.

        Raises:
            GoneError: the body has been deleted, or is neither a model's nor a layer's.
        """
        owner = self.find(body_id)
        if owner is None:
            raise _core.GoneError("this body has been deleted, or is of no model or layer")
        return owner

    def find(self, body_id: int) -> Optional[Entity]:
        """The same; None if it is nobody's, as a body that a plugin has made for itself."""
        return self._owners.get(body_id)

    def __iter__(self) -> Iterator[Entity]:
        return iter(dict.fromkeys(self._owners.values()))
