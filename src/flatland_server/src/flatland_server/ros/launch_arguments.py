"""Refuses arguments of roslaunch that the launch file does not have; roslaunch ignores them."""

import os
import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import List, Sequence

from flatland_server.exceptions import FlatlandError, suggestion

_ARGUMENT = re.compile(r"([A-Za-z]\w*):=")
_LAUNCH_FILE = re.compile(r"\.(launch|test|xml)$")


def check_launch_arguments(launch_files: Sequence[Path], command_line: Sequence[str]) -> None:
    """Checks the arguments on the command line that has started this node.

    Nothing is refused if another launch file has started it, which may include one of these and
    have arguments of its own.

    Args:
        launch_files: the launch file that starts this node; and others that include it and hand all
            arguments on to it.
        command_line: arguments of the parent process, which is roslaunch.

    Raises:
        FlatlandError: the launch file does not have one of the arguments.
    """
    if not _is_started_by(launch_files, command_line):
        return
    root = ElementTree.parse(launch_files[0]).getroot()
    known = [arg.get("name", "") for arg in root.iterfind("arg") if arg.get("value") is None]
    for word in command_line:
        match = _ARGUMENT.match(word)
        if match and match[1] not in known:
            hint = suggestion(match[1], known)
            raise FlatlandError(
                f'{launch_files[0].name} has no argument "{match[1]}"{hint}; '
                f"it has: {', '.join(known)}"
            )


def parent_command_line() -> List[str]:
    """The words of the command line of this process's parent; none if it cannot be read."""
    try:
        return Path(f"/proc/{os.getppid()}/cmdline").read_text(errors="replace").split("\0")[:-1]
    except OSError:
        return []


def _is_started_by(launch_files: Sequence[Path], command_line: Sequence[str]) -> bool:
    """True if a command line has one of these launch files, by path or package, and no other."""
    found = [
        (package, word)
        for package, word in zip(["", *command_line], command_line)
        if _LAUNCH_FILE.search(word) and not _ARGUMENT.match(word)
    ]
    if len(found) != 1:
        return False
    [(package, word)] = found
    return any(
        (word == file.name and package in file.parts)
        or (os.path.exists(word) and os.path.samefile(word, file))
        for file in launch_files
    )
