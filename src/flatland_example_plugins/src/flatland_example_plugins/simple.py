"""Simple: the smallest plugin."""

import logging

from flatland_server import ModelPlugin, YamlReader

logger = logging.getLogger(__name__)


class Simple(ModelPlugin):
    """Says hello when its model is spawned."""

    def on_initialize(self, config: YamlReader) -> None:
        """Reads nothing."""
        logger.info("Hello world")
