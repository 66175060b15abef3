"""Writes the definitions of src/flatland_msgs as ROS 2 has them: `interfaces.py FROM TO`.

ROS 2 has no capitals in names of fields, and times are messages.
"""

import re
import sys
from pathlib import Path

_FIELD = re.compile(r"^(\s*)([A-Za-z][\w/]*)(\S*\s+)(\w+)(?=\s*(#|$))", re.MULTILINE)
_TYPES = {"time": "builtin_interfaces/Time", "duration": "builtin_interfaces/Duration"}


def converted(definition: str) -> str:
    """A definition of ROS 1 as one of ROS 2."""

    def field(match: "re.Match[str]") -> str:
        indent, kind, array, name, _ = match.groups()
        return f"{indent}{_TYPES.get(kind, kind)}{array}{name.lower()}"

    return _FIELD.sub(field, definition)


if __name__ == "__main__":
    source, target = map(Path, sys.argv[1:])
    for file in sorted([*source.glob("msg/*.msg"), *source.glob("srv/*.srv")]):
        written = target / file.relative_to(source)
        written.parent.mkdir(parents=True, exist_ok=True)
        text = converted(file.read_text(encoding="utf-8"))
        if not written.exists() or written.read_text(encoding="utf-8") != text:
            written.write_text(text, encoding="utf-8")
        print(written.relative_to(target))
