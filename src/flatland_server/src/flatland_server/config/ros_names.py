"""Names of ROS topics and frames: checks of their parts, and frames within a namespace."""

import re
from typing import Optional

from flatland_server.config.yaml_reader import YamlReader

_TOPIC_NAME = re.compile(r"[A-Za-z0-9_]+(/[A-Za-z0-9_]+)*")


def topic_name_problem(name: str) -> Optional[str]:
    """Why the name of a model or layer cannot be part of a topic, or None if it can."""
    if _TOPIC_NAME.fullmatch(name):
        return None
    if not name:
        return "expected a name, found an empty one"
    return f'expected a name of letters, digits and "_" (it names a ROS topic), found "{name}"'


def namespace_problem(namespace: str) -> Optional[str]:
    """Why a namespace cannot be used, or None if it can. The empty namespace is valid."""
    bare = namespace.strip("/")
    if not bare or (_TOPIC_NAME.fullmatch(bare) and not bare[0].isdigit() and bare[0] != "_"):
        return None
    return (
        'expected a namespace of letters, digits and "_", beginning with a letter, '
        f'found "{namespace}"'
    )


def namespaced_frame(namespace: str, frame_id: str) -> str:
    """A frame within a model's namespace: `<namespace>_<frame>`, or `<frame>` without one."""
    return f"{namespace}_{frame_id}" if namespace else frame_id


def check_topic_name(reader: YamlReader, key: str, name: str) -> None:
    """Notes a problem if the name given at a key cannot be part of a topic.

    Args:
        reader: of the map that has the key.
        key: at which the name is given.
        name: the name.
    """
    problem = topic_name_problem(name)
    if problem and reader.has(key):
        reader.problem(problem, key)
