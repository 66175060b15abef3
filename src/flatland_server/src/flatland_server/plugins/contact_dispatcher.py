"""Delivers contact events to the plugins that override the hook for them.

The core reports only the contacts of bodies for which a listener is registered, and of these only
the events for which a hook is overridden; all others cost nothing.
"""

import weakref
from operator import attrgetter
from typing import Any, Callable, Dict, Iterable, List, NamedTuple, Optional, Sequence

from flatland_server import _core
from flatland_server.models.entity import Entities, Entity
from flatland_server.plugins.plugin import CONTACT_HOOKS, Plugin

Hook = Callable[..., None]

_HOOK_NAMES = {event: name for name, event in CONTACT_HOOKS.items()}


class _Listener(NamedTuple):
    """A plugin's hook for one kind of event."""

    order: int
    plugin: Plugin
    hook: Hook


class ContactDispatcher:
    """Calls the contact hooks of plugins, in the order in which the plugins were started.

    Args:
        physics: physical world with the contacts.
        entities: the models and layers of this world.
        call: called with a plugin, the name of its hook, the hook and its arguments; calls the hook
            and handles its exceptions.
    """

    def __init__(self, physics: _core.World, entities: Entities, call: Callable[..., None]) -> None:
        self._entities = entities
        self._call = call
        self._count = 0
        self.before_delivery: Optional[Callable[[], None]] = None
        """Called before the hooks of each event, if it is set."""
        # By event, then by the model of the plugins; those of world plugins are under None.
        self._listeners: Dict[int, Dict[Optional[Entity], List[_Listener]]] = {
            event: {} for event in CONTACT_HOOKS.values()
        }
        # A weak reference, or the core would keep its own world alive.
        weak_self = weakref.ref(self)

        def deliver(event: int, *details: Any) -> None:
            dispatcher = weak_self()
            if dispatcher is not None:
                dispatcher._deliver(event, *details)

        physics.set_contact_listener(deliver)

    @property
    def is_listening(self) -> bool:
        """True if a plugin has a contact hook."""
        return any(self._listeners.values())

    def add(self, plugin: Plugin, entity: Optional[Entity], hooks: Dict[str, Hook]) -> None:
        """Registers the contact hooks of a plugin.

        Args:
            plugin: plugin to call after those that were added before.
            entity: its model; None for a plugin of the world, which gets all contacts.
            hooks: the hooks that it overrides, by name.
        """
        self._count += 1
        overridden = [
            (event, hooks[name]) for name, event in CONTACT_HOOKS.items() if name in hooks
        ]
        for event, hook in overridden:
            listener = _Listener(self._count, plugin, hook)
            self._listeners[event].setdefault(entity, []).append(listener)
        if overridden:
            self._update_core([entity] if entity is not None else self._entities)

    def remove(self, plugins: Sequence[Plugin]) -> None:
        """Unregisters the hooks of these plugins."""
        removed = {id(plugin) for plugin in plugins}
        changed: Dict[Optional[Entity], None] = {}  # in the order of the listeners
        for by_entity in self._listeners.values():
            for entity, listeners in list(by_entity.items()):
                left = [each for each in listeners if id(each.plugin) not in removed]
                if len(left) < len(listeners):
                    changed[entity] = None
                    by_entity[entity] = left
                if not left:
                    del by_entity[entity]
        if None in changed:
            self._update_core(self._entities)
        else:
            self._update_core([entity for entity in changed if entity is not None])

    def refresh(self, entity: Entity) -> None:
        """Extends the reported contacts to new bodies of an entity, for plugins of the world."""
        if any(None in by_entity for by_entity in self._listeners.values()):
            self._update_core([entity])

    def _update_core(self, entities: Iterable[Entity]) -> None:
        """Tells the core which events to report for the bodies of these entities."""
        for entity in entities:
            events = 0
            for event, by_entity in self._listeners.items():
                if None in by_entity or entity in by_entity:
                    events |= event
            for body in entity.physics_bodies:
                if body.alive:
                    body.listen_to_contacts(events)

    def _deliver(
        self, event: int, id_a: int, id_b: int, contact: _core.Contact, *details: Any
    ) -> None:
        if self.before_delivery is not None:
            self.before_delivery()
        name = _HOOK_NAMES[event]
        by_entity = self._listeners[event]
        # None for the plugins of the world; a contact within a model is delivered once.
        entities = dict.fromkeys([self._entities.find(id_a), self._entities.find(id_b), None])
        listeners = [each for entity in entities for each in by_entity.get(entity, ())]
        if len(listeners) > 1:
            listeners.sort(key=attrgetter("order"))
        for _, plugin, hook in listeners:
            self._call(plugin, name, hook, contact, *details)
