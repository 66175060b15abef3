"""A simulation with its robots: commands and measurements in one world."""

from typing import List, Optional, Sequence

import numpy as np

from flatland2d import ModelHandle, Pose, Simulation
from flatland_gym.episodes import Episode
from flatland_gym.navigation_world import NavigationWorld
from flatland_gym.robot_rows import RobotRows
from flatland_gym.settings import NavigationSettings
from flatland_server import BoolArray, ModelPlugin


class RobotSimulation:
    """A simulation of a world, with one robot or several.

    Args:
        world: that is simulated.
        settings: of the environment.
    """

    def __init__(self, world: NavigationWorld, settings: NavigationSettings) -> None:
        self._world = world
        self._settings = settings
        self._simulation: Optional[Simulation] = None  # made with the seed of the first episode
        self._handles: List[ModelHandle] = []
        self._numbers = {name: number for number, name in enumerate(world.robots)}
        self._drives: List[ModelPlugin] = []
        self._lidars: List[ModelPlugin] = []

    @property
    def simulation(self) -> Simulation:
        """The simulation; there is none before the first episode."""
        assert self._simulation is not None
        return self._simulation

    def begin(self, episode: Episode) -> None:
        """Resets the world, and puts everything in its place."""
        if self._simulation is None:
            self._simulation = Simulation(
                self._world.config,
                seed=episode.seed,
                step_size=self._settings.step_size,
                params=self._settings.params,
            )
            self._handles = [self.simulation.models[name] for name in self._world.robots]
        else:
            self.simulation.reset(episode.seed)
        for name, start in zip(self._world.robots, episode.starts):
            self.simulation.move(name, start)
        for name, pose in episode.places.items():
            self.simulation.move(name, pose)
        robot = self._world.robot
        self._drives = [handle.plugin(robot.drive) for handle in self._handles]
        self._lidars = [handle.plugin(robot.lidar) for handle in self._handles]

    def is_blocked(self, episode: Episode) -> bool:
        """Whether a start or a goal lies in walls that plugins, such as RandomWall, have added."""
        config = self._world.config
        added = [
            layer.segments[len(config.walls_of(layer.config)) :]
            for layer in self.simulation.world.layers
        ]
        room = self._world.radius + self._settings.margin
        return episode.is_near(np.concatenate([np.empty((0, 4)), *added]), room)

    def command(self, number: int, values: Sequence[float]) -> None:
        """Commands the drive of a robot."""
        self._drives[number].command(*values)

    def step(self, count: int) -> BoolArray:
        """Makes some steps; returns whether each robot has touched something solid meanwhile."""
        collided = np.zeros(len(self._world.robots), dtype=bool)
        for _ in range(count):
            self.simulation.step()
            for touch in self.simulation.contacts:
                if touch.points and touch.model_a != touch.model_b:
                    for name in (touch.model_a, touch.model_b):
                        if name in self._numbers:
                            collided[self._numbers[name]] = True
        return collided

    def look(self, rows: RobotRows, row: int, number: int = 0) -> None:
        """Writes the measurements of a robot into a row."""
        handle = self._handles[number]
        rows.ranges[row] = self._lidars[number].read(self.simulation.timekeeper)
        rows.poses[row] = handle.pose
        rows.velocities[row] = handle.local_velocity

    def close(self) -> None:
        """Ends the simulation."""
        if self._simulation is not None:
            self._simulation.close()

    def remove(self, number: int, place: Pose) -> None:
        """Takes a robot out of the way, and stops it."""
        self.command(number, [0.0] * len(self._world.robot.action_limits))
        self.simulation.move(self._world.robots[number], place)
