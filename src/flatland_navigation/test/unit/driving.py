"""A robot of a `Simulation`, driven by a `Navigator` as the node drives one over ROS."""

import math
from typing import Any, Optional

import numpy as np

from flatland_navigation.grid import Grid
from flatland_navigation.navigator import Navigator, NavigatorConfig, Status
from flatland_navigation.obstacles import scan_points
from flatland_server import Pose
from flatland_server.testing import Harness

LASER = Pose(0.05)
"""Where the office's robot has its laser."""


def walls_of(simulation: Harness) -> Any:
    return np.concatenate([layer.segments for layer in simulation.world.layers])


class Driver:
    """Reads a robot's ground truth and scan, and commands it at 20 Hz."""

    def __init__(
        self,
        simulation: Harness,
        grid: Grid,
        namespace: str = "",
        config: Optional[NavigatorConfig] = None,
    ) -> None:
        self.navigator = Navigator(grid, config or NavigatorConfig())
        self.pose = Pose()
        self._simulation = simulation
        self._prefix = f"/{namespace}" if namespace else ""
        self._scan: Any = None
        self._last_time = -math.inf

    def step(self) -> None:
        """Handles the messages of the last step."""
        odometry = self._simulation.last(f"{self._prefix}/odometry/ground_truth")
        time = odometry.header.stamp.to_sec()
        if time - self._last_time < 0.0499:
            return
        self._last_time = time
        position, orientation = odometry.pose.pose.position, odometry.pose.pose.orientation
        self.pose = Pose(position.x, position.y, 2 * math.atan2(orientation.z, orientation.w))
        scan = self._simulation.last(f"{self._prefix}/scan")
        if scan is not None and scan is not self._scan:
            self._scan = scan
            points = scan_points(
                scan.ranges,
                scan.angle_min,
                scan.angle_increment,
                scan.range_max,
                self.pose.compose(LASER),
            )
            self.navigator.observe(points, scan.header.stamp.to_sec())
        command = self.navigator.update(self.pose, time)
        self._simulation.drive(command.forwards, command.turn, topic=f"{self._prefix}/cmd_vel")


def drive(simulation: Harness, *drivers: Driver, limit: float = 120.0) -> float:
    """Lets drivers drive until none has a goal, and returns the simulated time that it took [s]."""
    start = simulation.timekeeper.seconds
    while any(driver.navigator.status is Status.ACTIVE for driver in drivers):
        assert simulation.timekeeper.seconds - start < limit, "they are still driving"
        simulation.run()
        for driver in drivers:
            driver.step()
    return simulation.timekeeper.seconds - start
