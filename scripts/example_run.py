"""An example of examples/ in this process: its world, and its drivers as its launch file has them.

For the test of the examples and for their pictures: simulated time costs a fraction of real time,
and there is no window.
"""

import importlib.machinery
import importlib.util
import math
import shlex
from pathlib import Path

import numpy as np
import yaml
from roslaunch.config import load_config_default

from flatland2d import Pose, Simulation
from flatland_navigation.grid import Grid
from flatland_navigation.navigator import Navigator, NavigatorConfig, Status
from flatland_navigation.obstacles import scan_points

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
PERIOD = 0.05  # s: between commands
_LASER = Pose(0.05)  # mounting pose on the office's robot
_ANY_PORT = 11311


class ExampleRun:
    """Runs an example.

    Args:
        name: name of its folder in examples/.
        arguments: of its launch file, such as "robots:=2".
    """

    def __init__(self, name, *arguments):
        launch = str(EXAMPLES / name / f"{name}.launch")
        self.config = load_config_default([(launch, list(arguments))], _ANY_PORT, verbose=False)
        world = self._parameter("/flatland_server/world_path")
        self.simulation = Simulation(world)
        for node in self.config.nodes:
            if node.type == "spawn_robot":
                self._spawn(node)
        self.drivers = [driver for node in self.config.nodes for driver in self._drivers_of(node)]

    def _parameter(self, name, default=None):
        parameter = self.config.params.get(name)
        return default if parameter is None else parameter.value

    def _spawn(self, node):
        values = {
            key: self._parameter(f"{node.namespace}{node.name}/{key}")
            for key in ("namespace", "model", "x", "y", "yaw")
        }
        pose = (values["x"], values["y"], values["yaw"])
        name = values["namespace"]
        self.simulation.spawn(values["model"], name=name, namespace=name, pose=pose)

    def _drivers_of(self, node):
        """The drivers that stand in for a node of the launch file."""
        if node.type == "rostopic":
            command = yaml.safe_load(shlex.split(node.args)[-1])
            if "cmd_vel" in node.args:
                yield Constant(self._robot_named(), command["linear"]["x"], command["angular"]["z"])
        elif node.type == "send_goals":
            goals = yaml.safe_load(str(self._parameter(f"{node.namespace}{node.name}/goals")))
            robot = self._robot_named(node.namespace.strip("/"))
            yield Tour(self.simulation, robot, goals, self._grid())
        elif node.type == "fleet":
            fleet = _load(EXAMPLES / "warehouse" / "fleet")
            for name in node.args.split():
                yield Carrier(self.simulation, self.simulation.models[name], fleet.Carrier())
        elif node.type == "follow_the_gap":
            program = _load(EXAMPLES / "racecar" / "follow_the_gap")
            yield Racer(self._robot_named(), program.follow_the_gap)

    def _robot_named(self, name=""):
        """The model of a name; without a name, the model with a drive."""
        models = self.simulation.models
        return models[name] if name else next(each for each in models.values() if each.drives)

    def _grid(self):
        walls = np.concatenate([layer.segments for layer in self.simulation.world.layers])
        return Grid.from_walls(walls, 0.25, 0.1)

    def step(self):
        """Moves the world and its drivers on by PERIOD."""
        for driver in self.drivers:
            driver.step(self.simulation.time)
        self.simulation.step(round(PERIOD / self.simulation.step_size))

    def close(self):
        """Ends the simulation."""
        self.simulation.close()


class Constant:
    """Gives one command."""

    def __init__(self, robot, *command):
        self.robot, self._command = robot, command

    def step(self, time):
        """Commands the robot."""
        self.robot.command(*self._command)


class Tour:
    """Drives a robot to goals with the navigator of flatland_navigation.

    Attributes:
        robot: its model.
        reached: how many goals it has been to.
    """

    def __init__(self, simulation, robot, goals, grid):
        self.reached = 0
        self._simulation = simulation
        self.robot = robot
        self._goals = [Pose(*goal) for goal in goals]
        self._navigator = Navigator(grid, NavigatorConfig(stuck_after=60.0))
        self._scan = None

    def step(self, time):
        """Commands the robot."""
        if self._navigator.status is not Status.ACTIVE:
            self.reached += self._navigator.status is Status.SUCCEEDED
            self._navigator.set_goal(self._goals[self.reached % len(self._goals)])
        pose = Pose(*self.robot.pose)
        scan = self._simulation.last(f"{self.robot.namespace}/scan".lstrip("/"))
        if scan is not self._scan:
            self._scan = scan
            points = scan_points(
                scan.ranges,
                scan.angle_min,
                scan.angle_increment,
                scan.range_max,
                pose.compose(_LASER),
            )
            self._navigator.observe(points, time)
        command = self._navigator.update(pose, time)
        self.robot.command(command.forwards, command.turn)


class Carrier:
    """Drives a robot as the node fleet does."""

    def __init__(self, simulation, robot, carrier):
        self._simulation, self.robot, self._carrier = simulation, robot, carrier

    def step(self, time):
        """Commands the robot."""
        self._carrier.on_scan(self._simulation.last(f"{self.robot.namespace}/scan".lstrip("/")))
        self.robot.command(*self._carrier.command(*self.robot.pose))


class Racer:
    """Drives a car as the node follow_the_gap does.

    Attributes:
        robot: its model.
        laps: about the origin.
    """

    def __init__(self, robot, follow):
        self.robot, self._follow = robot, follow
        self._laser = robot.sensors["laser"]
        self._last = self._angle()
        self.laps = 0.0

    def _angle(self):
        return math.atan2(self.robot.pose.y, self.robot.pose.x)

    def step(self, time):
        """Commands the car."""
        angle = self._angle()
        self.laps += math.remainder(angle - self._last, math.tau) / math.tau
        self._last = angle
        start, following = self._laser.angles[:2]
        self.robot.command(*self._follow(self._laser.read(), start, following - start))


def _load(path):
    loader = importlib.machinery.SourceFileLoader(path.name, str(path))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(path.name, loader))
    loader.exec_module(module)
    return module
