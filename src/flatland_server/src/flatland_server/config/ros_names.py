"""Names that become part of a ROS topic."""

import re
from typing import Optional

from flatland_server.config.yaml_reader import YamlReader

_TOPIC_NAME = re.compile(r"[A-Za-z0-9_]+(/[A-Za-z0-9_]+)*")


def topic_name_problem(name: str) -> Optional[str]:
    """Why a model's or layer's name cannot be part of a topic, or None."""
    if _TOPIC_NAME.fullmatch(name):
        return None
    if not name:
        return "expected a name, found an empty one"
    return f'expected a name of letters, digits and "_" (it names a ROS topic), found "{name}"'


def namespace_problem(namespace: str) -> Optional[str]:
    """Why a namespace cannot be used, or None. The empty namespace can be."""
    bare = namespace.strip("/")
    if not bare or (_TOPIC_NAME.fullmatch(bare) and not bare[0].isdigit() and bare[0] != "_"):
        return None
    return (
        'expected a namespace of letters, digits and "_", beginning with a letter, '
        f'found "{namespace}"'
    )


def check_topic_name(reader: YamlReader, key: str, name: str) -> None:
    """Notes a problem at `key` if the name that is given there cannot be part of a topic."""
    problem = topic_name_problem(name)
    if problem and reader.has(key):
        reader.problem(problem, key)
