"""Plugins that belong to a model: drives, sensors, whatever a robot does."""

from typing import Any

import numpy as np

from flatland_server.exceptions import ModelError
from flatland_server.model import Model
from flatland_server.model_body import ModelBody
from flatland_server.node import Node
from flatland_server.plugin import Plugin
from flatland_server.yaml_reader import REQUIRED, YamlReader


class ModelPlugin(Plugin):
    """A plugin of one model; `self.model` is the model, `self.node` is in its namespace.

    See `flatland_server.plugin` for the life of a plugin.
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
            if name:
                config.problem(str(error), key)
            return self.model.base

    def name_space_tf(self, frame_id: str) -> str:
        """A frame's name with the model's namespace; see `Model.name_space_tf`."""
        return self.model.name_space_tf(frame_id)
