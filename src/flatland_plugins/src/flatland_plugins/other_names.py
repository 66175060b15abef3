"""Keys with two names, for files that were written for other simulators."""

from flatland_server import YamlReader


def given_name(config: YamlReader, key: str, other: str) -> str:
    """The one of a key's two names that is given, by default the first.

    Args:
        config: map that has the key; a problem is noted if both names are given.
        key: documented name of the key.
        other: alternative name of the key.
    """
    if config.has(key) and config.has(other):
        config.problem(f'"{key}" and "{other}" are one key: give one', other)
    return other if config.has(other) else key
