"""DummyModelPlugin: a plugin of a model that does nothing."""

from flatland_server import BatchRole, ModelPlugin, YamlReader


class DummyModelPlugin(ModelPlugin):
    """Accepts any keys: a placeholder, as for a plugin that is not there yet."""

    batch_role = BatchRole()

    def on_initialize(self, config: YamlReader) -> None:
        config.accept_other_keys()

    def get_state(self) -> None:
        """Nothing."""
