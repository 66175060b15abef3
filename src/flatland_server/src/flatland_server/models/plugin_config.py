"""An entry of `plugins` in the file of a model or a world."""

from dataclasses import dataclass

from flatland_server.config.yaml_reader import YamlReader


@dataclass(frozen=True)
class PluginConfig:
    """The type and name of a plugin.

    Attributes:
        type: the name of its class.
        name: unique within the model or the world.
        reader: of the entry; the plugin reads its other keys when it starts.
    """

    type: str
    name: str
    reader: YamlReader

    @classmethod
    def read(cls, reader: YamlReader) -> "PluginConfig":
        """Reads the keys that all plugins have.

        Plugins of the original read their keys themselves: the last one of equal keys counted.

        Raises:
            YamlError: there is no type or no name, or the name is not allowed for a frame.
        """
        reader.accept_repeated_keys()
        plugin = cls(reader.get_string("type"), reader.get_name("name"), reader)
        for key in ("type", "name"):
            if not reader.has(key):  # only the plugin knows which other keys there are
                reader.suggest(key)
        reader.raise_problems()
        return plugin
