"""An entry of `plugins`, in a model's or a world's file."""

from dataclasses import dataclass
from typing import List, Set

from flatland_server.yaml_reader import YamlReader


@dataclass(frozen=True)
class PluginConfig:
    """Which plugin, under which name; the rest of the entry is the plugin's own to read."""

    type: str
    name: str
    reader: YamlReader


def read_plugins(reader: YamlReader) -> List[PluginConfig]:
    """The entries of a file's `plugins` that are not switched off.

    Raises:
        YamlError: an entry has no type or no name, or a name is given twice.
    """
    plugins: List[PluginConfig] = []
    names: Set[str] = set()
    for section in reader.get_sections("plugins"):
        if not section.get_bool("enabled", True):
            continue
        plugin = PluginConfig(section.get_string("type"), section.get_string("name"), section)
        if plugin.name in names:
            raise section.error(f'the name "{plugin.name}" is given twice', "name")
        names.add(plugin.name)
        plugins.append(plugin)
    return plugins
