"""Model-predictive path integral control (MPPI): the robot tries commands in branches of its world.

Ten times a second, 64 branches of the simulation drive 1.5 s ahead, each with random
changes of the present plan. The next plan is their mean, weighted by exp(-cost / TEMPERATURE): G.
Williams et al., Information theoretic MPC for model-based reinforcement learning, ICRA 2017,
algorithm 2.
"""

import numpy as np

from flatland_navigation.grid import Grid
from flatland_navigation.planner import plan

BRANCHES = 64
HORIZON = 15  # commands of a plan
PERIOD = 20  # steps of a command: 0.1 s
LOWEST, HIGHEST = np.array([-0.1, -1.5]), np.array([0.6, 1.5])  # commands [m/s, rad/s]
SPREAD = np.array([0.25, 0.8])  # standard deviation of the random changes
HELD = 5  # commands that get the same change
TEMPERATURE = 0.05
RADIUS = 0.2  # of the robot [m]
AHEAD = 20  # points of the way, 0.1 m apart, that the robot looks ahead
MARGIN = 0.15  # from obstacles, below which it gets expensive [m]


class Route:
    """The way to the goal on the map, which does not have the boxes in it."""

    def __init__(self, simulation, start, goal):
        walls = np.concatenate([layer.segments for layer in simulation.world.layers])
        corners = plan(Grid.from_walls(walls, RADIUS + 0.1), tuple(start), tuple(goal))
        lengths = np.hypot(*np.diff(corners, axis=0).T)
        at = np.concatenate([[0.0], np.cumsum(lengths)])
        places = np.append(np.arange(0.0, at[-1], 0.1), at[-1])
        self.points = np.stack([np.interp(places, at, each) for each in corners.T], axis=1)

    def ahead(self, place):
        """The point of the way that the robot heads for from a place."""
        self.points = self.points[np.linalg.norm(self.points - place, axis=1).argmin() :]
        return self.points[min(AHEAD, len(self.points) - 1)]


class Planner:
    """The plan, and the batch in which it is tried."""

    def __init__(self, simulation, goal, rng):
        self.simulation, self.rng = simulation, rng
        self.batch = simulation.branch(BRANCHES)
        self.out = self.batch.observe()
        self.route = Route(simulation, self.out.poses[0, :2], goal)
        self.plan = np.zeros((HORIZON, 2))

    def command(self):
        """The best command now: speed [m/s] and yaw rate [rad/s]."""
        noise = self.rng.normal(scale=SPREAD, size=(BRANCHES, HORIZON // HELD, 2))
        noise[0] = 0.0
        commands = np.clip(self.plan + noise.repeat(HELD, axis=1), LOWEST, HIGHEST)
        costs = self.costs(commands)
        changes = (commands - self.plan)[:, ::HELD]
        costs += TEMPERATURE * (self.plan[::HELD] / SPREAD**2 * changes).sum(axis=(1, 2))
        weights = np.exp((costs.min() - costs) / TEMPERATURE)
        self.plan = np.tensordot(weights / weights.sum(), commands, axes=1)
        command = self.plan[0]
        self.plan = np.concatenate([self.plan[1:], self.plan[-1:]])
        return command

    def costs(self, commands):
        """Tries commands, a plan in each branch; returns the cost of each."""
        self.batch.load_states(self.simulation.save_state(), out=self.out)
        target = self.route.ahead(self.out.poses[0, :2])
        costs, has_hit = np.zeros(BRANCHES), np.zeros(BRANCHES, bool)
        for step in range(HORIZON):
            self.batch.step(commands[:, step], PERIOD, out=self.out)
            has_hit |= self.out.collided
            room = self.out.ranges.min(axis=1) - RADIUS
            costs += 10.0 * has_hit + 0.5 * np.maximum(0.0, 1.0 - room / MARGIN) ** 2
            left = np.linalg.norm(self.out.poses[:, :2] - target, axis=1)
            costs += left / HORIZON
        return costs + left


def mppi(run):
    """The controller of scenarios.yaml."""
    planner = Planner(run.simulation, run.goal, run.rng)
    with planner.batch:
        while run.is_running:
            run.robot.command(*planner.command())
            run.step()
