"""The executables of our packages."""

import os
from pathlib import Path

SRC = Path(__file__).resolve().parents[3]


def test_no_node_has_the_executable_bit():
    """Rosrun would find it besides catkin's relay, and ask which one is meant in some folders."""
    nodes = sorted(SRC.glob("*/nodes/*"))

    assert nodes
    assert [node for node in nodes if os.access(node, os.X_OK)] == []
