"""Runs the node, or says what it needs."""

import sys


def main() -> int:
    """Runs the node until it is told to end. Returns its exit code."""
    try:
        from flatland_bridge.ros2.server_node import main as run
    except ImportError as error:
        print(
            f"flatland_server: {sys.executable} cannot import {error.name or error}: "
            "pip install 'flatland2d[ros2]' for this Python (docs/ros2.md)",
            file=sys.stderr,
        )
        return 1
    return run()
