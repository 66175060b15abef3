"""What runs under a ROS master, and a port for one."""

import random
import socket
from pathlib import Path
from typing import List


def free_port() -> int:
    """A TCP port of this machine for a ROS master that is about to start.

    It lies below the range in which the kernel chooses ports itself (32768 and up), so that no
    other program gets it meanwhile.
    """
    draw = random.SystemRandom()  # hypothesis seeds the module's own generator
    while True:
        port = draw.randrange(15000, 32000)
        with socket.socket() as probe:
            try:
                probe.bind(("127.0.0.1", port))
            except OSError:
                continue
            return port


def processes_under(uri: str) -> List[bytes]:
    """Command lines of what knows this master, wherever it is in the process tree."""
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
