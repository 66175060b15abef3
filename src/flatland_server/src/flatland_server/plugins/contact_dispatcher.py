"""Brings contacts to the plugins that ask for them.

The core tells of the contacts of those bodies alone that somebody listens to, at the moments for
which a plugin overrides a hook: what nobody overrides costs nothing.
"""

import weakref
from typing import Any, Callable, Dict, List, NamedTuple, Optional, Sequence

from flatland_server import _core
from flatland_server.models.entity import Entities, Entity
from flatland_server.plugins.plugin import CONTACT_HOOKS, Plugin

Hook = Callable[..., None]

_NAMES = {moment: name for name, moment in CONTACT_HOOKS.items()}


class _Listener(NamedTuple):
    """A plugin's hook for one moment."""

    order: int
    plugin: Plugin
    hook: Hook


class ContactDispatcher:
    """Calls the contact hooks of plugins.

    Args:
        physics: the world whose contacts are told of.
        entities: of that world.
        call: calls a plugin's hook (of this name, this function) with its arguments, and deals with
            what it raises.
    """

    def __init__(self, physics: _core.World, entities: Entities, call: Callable[..., None]) -> None:
        self._entities = entities
        self._call = call
        self._started = 0
        # By moment, and by the model whose plugins they are; those of world plugins under None.
        self._listeners: Dict[int, Dict[Optional[Entity], List[_Listener]]] = {
            moment: {} for moment in CONTACT_HOOKS.values()
        }
        # The core must not keep its own world alive through us.
        myself = weakref.ref(self)

        def deliver(moment: int, *event: Any) -> None:
            dispatcher = myself()
            if dispatcher is not None:
                dispatcher._deliver(moment, *event)

        physics.set_contact_listener(deliver)

    def add(self, plugin: Plugin, entity: Optional[Entity], hooks: Dict[str, Hook]) -> None:
        """Listens for a plugin.

        Args:
            plugin: whose they are.
            entity: the model that it belongs to; None for a plugin of the world: it hears of all.
            hooks: those that it overrides, by name.
        """
        self._started += 1
        wanted = [(moment, hooks[name]) for name, moment in CONTACT_HOOKS.items() if name in hooks]
        for moment, hook in wanted:
            listener = _Listener(self._started, plugin, hook)
            self._listeners[moment].setdefault(entity, []).append(listener)
        if wanted:
            self._listen_to([entity] if entity is not None else self._entities)

    def remove(self, plugins: Sequence[Plugin]) -> None:
        """Listens no longer for these plugins."""
        gone = {id(plugin) for plugin in plugins}
        concerned: Dict[Optional[Entity], None] = {}
        for by_entity in self._listeners.values():
            for entity, listeners in list(by_entity.items()):
                left = [each for each in listeners if id(each.plugin) not in gone]
                if len(left) < len(listeners):
                    concerned[entity] = None
                    by_entity[entity] = left
                if not left:
                    del by_entity[entity]
        if None in concerned:
            self._listen_to(self._entities)
        else:
            self._listen_to([entity for entity in concerned if entity is not None])

    def refresh(self, entity: Entity) -> None:
        """An entity has got new bodies; plugins of the world hear of their contacts too."""
        if any(None in by_entity for by_entity in self._listeners.values()):
            self._listen_to([entity])

    def _listen_to(self, entities: Any) -> None:
        for entity in entities:
            hooks = 0
            for moment, by_entity in self._listeners.items():
                if None in by_entity or entity in by_entity:
                    hooks |= moment
            for body in entity.physics_bodies:
                if body.alive:
                    body.listen_to_contacts(hooks)

    def _deliver(
        self, moment: int, id_a: int, id_b: int, contact: _core.Contact, *details: Any
    ) -> None:
        name = _NAMES[moment]
        by_entity = self._listeners[moment]
        concerned = dict.fromkeys([self._entities.find(id_a), self._entities.find(id_b), None])
        listeners = [each for entity in concerned for each in by_entity.get(entity, ())]
        for _, plugin, hook in sorted(listeners, key=_order) if len(listeners) > 1 else listeners:
            self._call(plugin, name, hook, contact, *details)


def _order(listener: _Listener) -> int:
    """Plugins hear in the order in which they were started."""
    return listener.order
