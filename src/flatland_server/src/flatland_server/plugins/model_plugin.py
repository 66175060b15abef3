"""The base class of plugins that belong to a model, such as drives and sensors."""

from typing import Any, Callable, ClassVar, NamedTuple, Optional, Set, Tuple, TypeVar

import numpy as np

from flatland_server import _core
from flatland_server.config.yaml_reader import REQUIRED, YamlReader
from flatland_server.exceptions import ModelError
from flatland_server.models.entity import Entity
from flatland_server.models.joint import Joint
from flatland_server.models.model import Model
from flatland_server.models.model_body import ModelBody
from flatland_server.plugins.plugin import Plugin
from flatland_server.timekeeper import Timekeeper
from flatland_server.transport.node import Node

T = TypeVar("T")


class ContactSides(NamedTuple):
    """A contact as seen from a model."""

    entity: Entity
    """The `Layer` or `Model` that the model touches; it may be the model itself."""
    this_fixture: _core.Fixture
    """The fixture of the model."""
    other_fixture: _core.Fixture
    """The fixture of the entity."""


class ModelPlugin(Plugin):
    """A plugin of one model.

    `flatland_server.plugins.plugin` describes the life of a plugin.

    Attributes:
        type: its type, as in its configuration.
        name: unique among the plugins of its model.
        node: its access to topics, transforms and parameters, in the namespace of its model.
        rng: its random numbers, which depend only on the seed of the world and on the names of the
            model and the plugin.
        model: its model, with bodies and joints.
        quantities: names of further quantities that it measures: for each there is a method
            `read_<quantity>` with the same argument as `read`.
    """

    quantities: ClassVar[Tuple[str, ...]] = ()

    def __init__(
        self, type: str, name: str, node: Node, rng: np.random.Generator, model: Model
    ) -> None:
        super().__init__(type, name, node, rng)
        self.model = model

    def read(self, timekeeper: Timekeeper) -> Any:
        """Measures now: `simulation.models["robot"].sensors["name"].read()`.

        To be overridden by sensors. Called between steps, whether topics have subscribers or not.
        It changes nothing that the plugin publishes later, and has the measurement errors of a
        message at this time.

        Args:
            timekeeper: gives the simulated time.

        Returns:
            Anything; a new object each time, which the caller may keep and change.
        """
        raise NotImplementedError(f"{type(self).__name__} measures nothing")

    def command(self, *values: Any, **named_values: Any) -> None:
        """Obeys a command, as from a message: `simulation.models["robot"].command(0.5, 0.2)`.

        To be overridden by drives, with parameters of their own. Called between steps.

        Args:
            values: as the drive defines them, by their places.
            named_values: the same, by their names.

        Raises:
            ValueError: it cannot be obeyed; nothing has changed.
        """
        raise NotImplementedError(f"{type(self).__name__} takes no commands")

    def get_body(self, config: YamlReader, key: str = "body", default: Any = REQUIRED) -> ModelBody:
        """The body named by a key of the configuration.

        Args:
            config: the plugin's configuration.
            key: key of the body's name.
            default: the name if the key is missing; without it, the key is required.

        Returns:
            The body. If there is none of this name, the base of the model; the problem is then
            noted and raised by `config.finish()`.
        """
        return _named(self.model.get_body, config, key, default) or self.model.base

    def get_body_names(self, config: YamlReader, key: str) -> Set[str]:
        """The names of bodies in a list of the configuration, which is empty by default.

        A name that no body has is noted as a problem, which `config.finish()` raises.

        Args:
            config: the plugin's configuration.
            key: key of the list.
        """
        names = config.get_strings(key, ())
        for name in names:
            try:
                self.model.get_body(name)
            except ModelError as error:
                config.problem(str(error), key)
        return set(names)

    def get_joint(self, config: YamlReader, key: str, default: Any = REQUIRED) -> Optional[Joint]:
        """The joint named by a key of the configuration.

        Args:
            config: the plugin's configuration.
            key: key of the joint's name.
            default: its name if the key is missing, such as "" for no joint; without it, the key is
                required.

        Returns:
            The joint. None if there is none of this name; the problem is then noted and raised by
            `config.finish()`.
        """
        return _named(self.model.get_joint, config, key, default)

    def filter_contact(self, contact: _core.Contact) -> Optional[ContactSides]:
        """A contact as seen from this model.

        Args:
            contact: as passed to a hook.

        Returns:
            None if the model is not part of the contact, or the other body belongs neither to a
            model nor to a layer: one that a plugin has added.

        Raises:
            GoneError: a body has been deleted.
        """
        entities = self.model.entities
        a, b = contact.fixture_a, contact.fixture_b
        owner_a, owner_b = entities.find(a.body.id), entities.find(b.body.id)
        if owner_a is None or owner_b is None:
            if a.body.alive and b.body.alive:
                return None
            raise _core.GoneError("a body of this contact has been deleted")
        if owner_a is self.model:
            return ContactSides(owner_b, a, b)
        return ContactSides(owner_a, b, a) if owner_b is self.model else None

    def name_space_tf(self, frame_id: str) -> str:
        """The name of one of the model's frames, with its namespace; see `Model.name_space_tf`.

        Args:
            frame_id: name of the frame, without the namespace.
        """
        return self.model.name_space_tf(frame_id)


def _named(get: Callable[[str], T], config: YamlReader, key: str, default: Any) -> Optional[T]:
    """The body or joint named by a key; None, with a problem that is noted, if there is none."""
    name = config.get_string(key, default)
    try:
        return get(name)
    except ModelError as error:
        if name or (config.has(key) and config.is_sound):
            config.problem(str(error), key)
        return None
