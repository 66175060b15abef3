"""Lists whose entries have names and can be switched off: models, bodies, joints, plugins."""

from typing import Callable, List, Optional, Set, TypeVar

from flatland_server.config.yaml_reader import YamlReader

T = TypeVar("T")


def read_enabled(
    reader: YamlReader, key: str, read: Callable[[YamlReader], T], *, required: bool = False
) -> List[T]:
    """What `read` makes of the entries of a list that are not switched off by `enabled: false`.

    Each entry needs a name of its own.
    """
    names: Set[str] = set()

    def read_entry(section: YamlReader) -> Optional[T]:
        if not section.get_bool("enabled", True):
            return None
        name = section.get_string("name")
        if name and name in names:
            section.problem(f'the name "{name}" is given twice', "name")
        names.add(name)
        return read(section)

    entries = reader.get_sections(key, read_entry, required=required)
    return [entry for entry in entries if entry is not None]
