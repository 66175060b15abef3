"""Drives the robots of a sweep (`flatland sweep`) by a trained policy."""

from functools import lru_cache

import numpy as np

from flatland2d import SensorHandle, UsageError
from flatland2d.sweep import SweepRun
from flatland_gym.policy import Policy
from flatland_server import Float32Array, FloatArray
from flatland_server._core import LinesOfSight


def drive(run: SweepRun, file: str) -> None:
    """A controller of sweeps: acts in the policy's own period until the run is over.

    Args:
        run: has a goal, and a robot with a lidar that has as many beams as the policy's. A policy
            with neighbours is told the true motions of the other models in sight.
        file: the policy's file.

    Raises:
        FlatlandError: the file is none of a policy, or the robot or the task do not fit to it.
    """
    policy = _load_once(file)
    lidar = _lidar_of(run, policy.beams)
    layers = run.simulation.world.layers
    hiding = [] if policy.neighbors_behind_walls else [layer.segments for layer in layers]
    walls = LinesOfSight(np.concatenate([np.empty((0, 4)), *hiding]))
    while run.is_running:
        robot = run.robot
        neighbors = _neighbors_of(run, walls) if policy.neighbors else None
        measured = lidar.read(), robot.pose, robot.local_velocity
        robot.command(*policy.drive(*measured, run.goal, neighbors))
        run.step(policy.period)


def _neighbors_of(run: SweepRun, walls: LinesOfSight) -> FloatArray:
    """The other models that these walls do not hide, as a policy takes them."""
    own = run.robot.model
    others = np.array(
        [
            (*model.pose[:2], *model.base.physics_body.velocity[:2], model.radius + own.radius)
            for model in run.simulation.world.models.values()
            if model is not own
        ]
    ).reshape(-1, 5)
    lines = np.concatenate([np.tile(own.pose[:2], (len(others), 1)), others[:, :2]], axis=1)
    return others[~walls.blocked(lines)]


def _lidar_of(run: SweepRun, beams: int) -> SensorHandle[Float32Array]:
    """The lidar with so many beams."""
    robot = run.robot
    roles = {name: robot.plugin(name).batch_role for name in robot.sensors}
    lidars = [robot.sensors[name] for name, role in roles.items() if role and role.lidar]
    counts = [len(each.read()) for each in lidars]
    if counts.count(beams) != 1:
        found = ", ".join(map(str, counts)) or "no lidar"
        raise UsageError(f"expected a robot with one lidar of {beams} beams, found {found}")
    return lidars[counts.index(beams)]


_load_once = lru_cache(maxsize=None)(Policy.load)
