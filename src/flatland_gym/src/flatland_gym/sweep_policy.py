"""Drives the robots of a sweep (`flatland sweep`) by a trained policy."""

from typing import Dict, List, Tuple

from flatland2d import SensorHandle, UsageError
from flatland2d.sweep import SweepRun
from flatland_gym.policy import Policy
from flatland_server import Float32Array


def drive(run: SweepRun, file: str) -> None:
    """A controller of sweeps: acts in the policy's own period until the run is over.

    Args:
        run: has a goal, and a robot with a lidar that has as many beams as the policy's. A policy
            with neighbours is told the true motions of the other models.
        file: of the policy.

    Raises:
        FlatlandError: the file is none of a policy, or the robot or the task do not fit to it.
    """
    policy = _load(file)
    lidar = _lidar_of(run, policy.beams)
    if run.goal is None:
        raise UsageError("expected a goal for the policy to drive to, found none")
    while run.is_running:
        robot = run.robot
        neighbors = _neighbors_of(run) if policy.neighbors else None
        measured = lidar.read(), robot.pose, robot.local_velocity
        robot.command(*policy.drive(*measured, run.goal, neighbors))
        run.step(policy.period)


def _neighbors_of(run: SweepRun) -> List[Tuple[float, ...]]:
    """The other models, as a policy takes them."""
    own = run.robot.model
    return [
        (*model.pose[:2], *model.base.physics_body.velocity[:2], model.radius + own.radius)
        for model in run.simulation.world.models.values()
        if model is not own
    ]


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


_policies: Dict[str, Policy] = {}


def _load(file: str) -> Policy:
    """The policy of a file, read once in a process."""
    if file not in _policies:
        _policies[file] = Policy.load(file)
    return _policies[file]
