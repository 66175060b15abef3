"""An entry of `plugins`, in a model's or a world's file."""

from dataclasses import dataclass

from flatland_server.config.yaml_reader import YamlReader


@dataclass(frozen=True)
class PluginConfig:
    """Which plugin, under which name; the rest of the entry is the plugin's own to read."""

    type: str
    name: str
    reader: YamlReader

    @classmethod
    def read(cls, reader: YamlReader) -> "PluginConfig":
        """Reads what all plugins have.

        Raises:
            YamlError: there is no type or no name.
        """
        plugin = cls(reader.get_string("type"), reader.get_string("name"), reader)
        for key in ("type", "name"):
            if not reader.has(key):  # which keys there are besides, only the plugin knows
                reader.suggest(key)
        reader.raise_problems()
        return plugin
