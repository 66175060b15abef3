"""The rooms in VMAS: teams of robots, each in a room of its own."""

import importlib.metadata
import math
from typing import Any, Dict

import torch
import vmas
from vmas.simulator.core import Agent, Landmark, Line, Sphere, World
from vmas.simulator.dynamics.diff_drive import DiffDrive
from vmas.simulator.scenario import BaseScenario
from vmas.simulator.sensors import Lidar

import scenario
from scenario import Scenario


class Rooms(BaseScenario):
    """The rooms as VMAS makes them. Observations are the scans; there is no reward."""

    def make_world(self, batch_dim: int, device: Any, **arguments: Any) -> World:
        """The robots, and the discs and walls unless `is_open`."""
        self._layout: Scenario = arguments["layout"]
        self._is_open: bool = arguments["is_open"]
        world = World(batch_dim, device, dt=scenario.STEP, substeps=1)
        for number in range(arguments["robots"]):
            lidar = Lidar(
                world,
                angle_start=scenario.FIRST_BEAM,
                angle_end=scenario.FIRST_BEAM + scenario.INCREMENT * (scenario.BEAMS - 1) - 1e-4,
                n_rays=scenario.BEAMS,
                max_range=scenario.RANGE,
            )
            agent = Agent(
                name=f"robot_{number}",
                shape=Sphere(radius=scenario.ROBOT_RADIUS),
                sensors=[lidar],
                dynamics=DiffDrive(world, integration="euler"),
                u_range=[scenario.SPEED, scenario.YAW_RATE],
            )
            world.add_agent(agent)
        if not self._is_open:
            discs = [Sphere(radius=scenario.DISC_RADIUS)] * scenario.DISCS
            for number, shape in enumerate([*discs, *[Line(length=scenario.ROOM)] * 4]):
                world.add_landmark(Landmark(f"obstacle_{number}", shape=shape, collide=True))
        return world

    def reset_world_at(self, env_index: Any = None) -> None:
        """Puts everything into its place, in all rooms."""
        agents, obstacles = self.world.agents, self.world.landmarks
        poses = torch.tensor(self._layout.poses, dtype=torch.float32)
        for agent, places in zip(agents, poses.reshape(-1, len(agents), 3).unbind(1)):
            agent.set_pos(places[:, :2], batch_index=None)
            agent.set_rot(places[:, 2:], batch_index=None)
        half, side = scenario.ROOM / 2, scenario.ROOM
        walls = [(half, 0.0, 0.0), (half, side, 0.0), (0.0, half, 1.0), (side, half, 1.0)]
        discs = [(x, y, 0.0) for x, y in self._layout.discs.tolist()]
        for obstacle, (x, y, turns) in zip(obstacles, [*discs, *walls]):
            obstacle.set_pos(torch.tensor([x, y]), batch_index=None)
            obstacle.set_rot(torch.tensor([turns * math.pi / 2]), batch_index=None)

    def reward(self, agent: Agent) -> Any:
        """Zeros."""
        return torch.zeros(self.world.batch_dim)

    def observation(self, agent: Agent) -> Any:
        """The scan."""
        return agent.sensors[0].measure()


class Teams:
    """Robots in many rooms, of which those of a room see and hit each other.

    Args:
        robots: how many in each room.
        seed: of the scenario.
        is_open: whether discs and walls are left out.
    """

    def __init__(self, robots: int, seed: int, is_open: bool) -> None:
        self.robots = robots * scenario.TEAMS
        self._scenario = Scenario(self.robots, seed, rooms=scenario.TEAMS)
        self._step = 0
        self._env = vmas.make_env(
            Rooms(), num_envs=scenario.TEAMS, robots=robots, layout=self._scenario, is_open=is_open
        )
        self._observations = self._env.reset()
        commands = torch.tensor(self._scenario.commands, dtype=torch.float32)
        shaped = commands.reshape(len(commands), scenario.TEAMS, robots, 2)
        self._commands = [list(block.unbind(1)) for block in shaped]

    def run(self, steps: int) -> None:
        """Commands, steps and scans; the scans are the observations."""
        for _ in range(steps):
            values = self._commands[self._scenario.command(self._step)]
            self._observations, *_ = self._env.step(list(values))
            self._step += 1

    def scans(self) -> Any:
        """The ranges of all lidars [m]."""
        return torch.stack(self._observations, dim=1).reshape(self.robots, -1).numpy()

    def close(self) -> None:
        """There is nothing to end."""


def open_room(kind: str, variant: str, robots: int, seed: int) -> Teams:
    """The rooms of the kind "team"."""
    return Teams(robots, seed, variant == "open")


def versions() -> Dict[str, str]:
    """The versions of the packages that are measured."""
    return {name: importlib.metadata.version(name) for name in ("vmas", "torch", "numpy")}
