"""Checks of names for ROS: of topics, frames, namespaces, models, layers, bodies and plugins.

A name has at most 255 characters. ROS itself has no limit, but bags and logs are named after
topics, and 255 is the limit of a file's name (NAME_MAX).
"""

import re
from typing import Optional, Tuple

from flatland_server.exceptions import shortened

MAX_LENGTH = 255  # characters

TOPIC = f'a topic of letters, digits, "_" and "/", at most {MAX_LENGTH} characters'
"""The names that `is_topic` accepts, as a phrase for error messages."""

FRAME = (
    f"a name without empty parts and spaces at its ends, at most {MAX_LENGTH} characters "
    "(it names a frame)"
)
"""The names that `is_frame` accepts, as a phrase for error messages."""

NAME = f"a name of at most {MAX_LENGTH} characters, on one line"
"""The names that `is_name` accepts, as a phrase for error messages."""

_TOPIC_NAME = re.compile(r"[A-Za-z0-9_]+(/[A-Za-z0-9_]+)*")
_FRAME = re.compile(r"/?[^\s/]+(( +|/)[^\s/]+)*")  # tf2 accepts more, but for an empty one


def is_topic(name: str) -> bool:
    """True if a topic can have this name, which may begin with "/"."""
    bare = name[1:] if name.startswith("/") else name
    return len(name) <= MAX_LENGTH and bool(_TOPIC_NAME.fullmatch(bare))


def is_frame(name: str) -> bool:
    """True if a frame can have this name, which may begin with "/"."""
    return len(name) <= MAX_LENGTH and bool(_FRAME.fullmatch(name))


def is_name(name: str) -> bool:
    """True if a body, joint or plugin can have this name: any text of one line."""
    return name.isprintable() and 0 < len(name) <= MAX_LENGTH


def topic_name_problem(name: str) -> Optional[str]:
    """Why the name of a model or layer cannot be part of a topic, or None if it can."""
    if _TOPIC_NAME.fullmatch(name):
        return _length_problem(name)
    if not name:
        return "expected a name, found an empty one"
    expected = 'expected a name of letters, digits and "_" (it names a ROS topic)'
    return f'{expected}, found "{shortened(name)}"'


def namespace_problem(namespace: str) -> Optional[str]:
    """Why a namespace cannot be used, or None if it can. The empty namespace is valid."""
    bare = bare_namespace(namespace)
    if not bare or (_TOPIC_NAME.fullmatch(bare) and not bare[0].isdigit() and bare[0] != "_"):
        return _length_problem(namespace)
    return (
        'expected a namespace of letters, digits and "_", beginning with a letter, '
        f'found "{shortened(namespace)}"'
    )


def bare_namespace(namespace: str) -> str:
    """A model's namespace without a "/" at its ends, and without the "~" of frames of its own."""
    return namespace[namespace.startswith("~") :].strip("/")


def namespaced_frame(namespace: str, frame_id: str) -> str:
    """A frame within a model's namespace: `<namespace>_<frame>`, or `<frame>` without one."""
    return f"{namespace}_{frame_id}" if namespace else frame_id


def tf_topics(namespace: str) -> Tuple[str, str]:
    """The topics of a namespace for transforms and static ones: `/tf`, `/tf_static` without one."""
    return f"{namespace}/tf", f"{namespace}/tf_static"


def _length_problem(name: str) -> Optional[str]:
    if len(name) <= MAX_LENGTH:
        return None
    return f"expected a name of at most {MAX_LENGTH} characters, found {len(name)}"
