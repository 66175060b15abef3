"""A TCP port for a ROS master of a test's own."""

import random
import socket


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
