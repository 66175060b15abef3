"""Processes under a ROS master, a free port for one, and the executables of nodes."""

from functools import lru_cache
from pathlib import Path
from typing import List

from roslib.packages import find_node

from flatland_server.testing.ports import free_port

__all__ = ["executable", "free_port", "processes_under"]


@lru_cache(maxsize=None)
def executable(package: str, node: str) -> str:
    """The file of a package's node; rosrun starts several processes to find it."""
    file: str = find_node(package, node)[0]
    return file


def processes_under(uri: str) -> List[bytes]:
    """Command lines of all processes with this master in their environment."""
    markers = [f"ROS_MASTER_URI={uri}{end}\0".encode() for end in ("", "/")]  # roslaunch adds one
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            environment = (process / "environ").read_bytes()
            if any(marker in environment for marker in markers):
                found.append((process / "cmdline").read_bytes())
        except OSError:
            continue
    return [command for command in found if command]
