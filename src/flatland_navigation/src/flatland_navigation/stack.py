"""Checks that the packages that navigation.launch starts are installed."""

import sys
from typing import List

import rospkg

PACKAGES = ("amcl", "dwa_local_planner", "map_server", "move_base", "navfn")
"""The packages of the ROS navigation stack that navigation.launch needs."""


def missing_packages() -> List[str]:
    """The members of `PACKAGES` that are not installed."""
    return sorted(set(PACKAGES) - set(rospkg.RosPack().list()))


def main() -> int:
    """Prints one line if a package is missing. Returns the exit code; 1 ends a launch."""
    missing = missing_packages()
    if not missing:
        return 0
    print(
        f"flatland_navigation: the navigation stack is not installed (missing: "
        f"{', '.join(missing)}); waypoints.launch and navigator:=waypoints need none of it",
        file=sys.stderr,
    )
    return 1
