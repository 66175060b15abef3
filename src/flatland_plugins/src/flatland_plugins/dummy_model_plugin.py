"""DummyModelPlugin: a plugin of a model that does nothing."""

from flatland_server import ModelPlugin, YamlReader


class DummyModelPlugin(ModelPlugin):
    """Accepts any keys: a placeholder, as for a plugin that is not there yet."""

    is_passive = True

    def on_initialize(self, config: YamlReader) -> None:
        config.accept_other_keys()

    def get_state(self) -> None:
        """Nothing."""
