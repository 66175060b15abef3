"""Entities: the models and layers of a world, which own its bodies."""

from abc import ABC, abstractmethod
from contextlib import suppress
from typing import Any, Dict, Iterable, Iterator, List, Optional, Sequence

from flatland_server import _core
from flatland_server.exceptions import StateError


class Entity(ABC):
    """A model or a layer: the partner in a contact, as plugins see it."""

    @property
    @abstractmethod
    def name(self) -> str:
        """The name of the model, or the first name of the layer."""

    @property
    def description(self) -> str:
        """Its kind and name, for messages."""
        return f'the {type(self).__name__.lower()} "{self.name}"'

    @property
    @abstractmethod
    def physics_bodies(self) -> List[_core.Body]:
        """Its bodies in the physical world."""

    @abstractmethod
    def body_name(self, fixture: _core.Fixture) -> str:
        """The name of the body that a fixture belongs to; for a layer, the name of the layer.

        Args:
            fixture: a fixture of this entity.

        Raises:
            ModelError: it is not of this entity, or the model has been deleted.
        """


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

    def clear(self) -> None:
        """Forgets all entities, so that nothing keeps them and their physical world alive."""
        self._owners.clear()

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
        """Like `owner`, but None for a body without one, such as a body created by a plugin."""
        return self._owners.get(body_id)

    def describe(self, fixture: _core.Fixture) -> List[Any]:
        """A fixture as plain data, for the state of a plugin; `fixture` finds it again.

        Raises:
            GoneError: its body has been deleted, or belongs to no model or layer.
        """
        owner = self.owner(fixture.body.id)
        body = owner.physics_bodies.index(fixture.body)
        return [type(owner).__name__, owner.name, body, fixture.index]

    def fixture(self, description: Sequence[Any]) -> _core.Fixture:
        """The fixture that `describe` has described, here or in a world of the same contents.

        Raises:
            StateError: there is none.
        """
        kind, name, body, index = description
        for entity in self:
            if type(entity).__name__ == kind and entity.name == name:
                bodies = entity.physics_bodies
                if 0 <= body < len(bodies) and index >= 0:
                    with suppress(IndexError):
                        found: _core.Fixture = bodies[body].fixture(index)
                        return found
        raise StateError(f'there is no fixture {index} of body {body} of "{name}"')

    def __iter__(self) -> Iterator[Entity]:
        return iter(dict.fromkeys(self._owners.values()))
