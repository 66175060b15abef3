"""Plugins that belong to a model: drives, sensors, whatever a robot does."""

from typing import Any, NamedTuple, Optional, Set

import numpy as np

from flatland_server import _core
from flatland_server.config.yaml_reader import REQUIRED, YamlReader
from flatland_server.exceptions import ModelError
from flatland_server.models.entity import Entity
from flatland_server.models.joint import Joint
from flatland_server.models.model import Model
from flatland_server.models.model_body import ModelBody
from flatland_server.plugins.plugin import Plugin
from flatland_server.transport.node import Node


class ContactSides(NamedTuple):
    """A contact from a model's point of view."""

    entity: Entity
    """What the model touches: a `Layer`, or a `Model`, which may be the same one."""
    this_fixture: _core.Fixture
    """What of the model touches it."""
    other_fixture: _core.Fixture
    """What of the entity is touched."""


class ModelPlugin(Plugin):
    """A plugin of one model; `self.model` is the model, `self.node` is in its namespace.

    See `flatland_server.plugins.plugin` for the life of a plugin.
    """

    def __init__(
        self, type: str, name: str, node: Node, rng: np.random.Generator, model: Model
    ) -> None:
        super().__init__(type, name, node, rng)
        self.model = model

    def get_body(self, config: YamlReader, key: str = "body", default: Any = REQUIRED) -> ModelBody:
        """The body that a key of the configuration names.

        If there is no such body, that is noted as a problem for `config.finish()` to raise.
        """
        name = config.get_string(key, default)
        try:
            return self.model.get_body(name)
        except ModelError as error:
            if name or (config.has(key) and config.is_sound):
                config.problem(str(error), key)
            return self.model.base

    def get_body_names(self, config: YamlReader, key: str) -> Set[str]:
        """The names in a list of bodies, empty by default; a name of none is noted as a problem."""
        names = config.get_strings(key, ())
        for name in names:
            try:
                self.model.get_body(name)
            except ModelError as error:
                config.problem(str(error), key)
        return set(names)

    def get_joint(self, config: YamlReader, key: str) -> Optional[Joint]:
        """The joint that a key of the configuration names.

        If there is no such joint, that is noted as a problem for `config.finish()` to raise, and
        None is returned.
        """
        name = config.get_string(key)
        try:
            return self.model.get_joint(name)
        except ModelError as error:
            if name or (config.has(key) and config.is_sound):
                config.problem(str(error), key)
            return None

    def filter_contact(self, contact: _core.Contact) -> Optional[ContactSides]:
        """The sides of a contact as this model has them; None if it has no part in it.

        A hook of a model's plugin is called only for contacts in which its model has a part.
        """
        entities = self.model.entities
        a, b = contact.fixture_a, contact.fixture_b
        owner_a, owner_b = entities.owner(a.body.id), entities.owner(b.body.id)
        if owner_a is self.model:
            return ContactSides(owner_b, a, b)
        return ContactSides(owner_a, b, a) if owner_b is self.model else None

    def name_space_tf(self, frame_id: str) -> str:
        """A frame's name with the model's namespace; see `Model.name_space_tf`."""
        return self.model.name_space_tf(frame_id)
