"""Contacts, as the hooks of plugins get them; what each offers is in `_core.pyi`."""

from flatland_server._core import Body, Contact, ContactImpulse, Fixture, GoneError, Manifold

__all__ = ["Body", "Contact", "ContactImpulse", "Fixture", "GoneError", "Manifold"]
