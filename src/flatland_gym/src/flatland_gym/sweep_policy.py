"""Drives the robots of a sweep (`flatland sweep`) by a trained policy."""

from typing import Dict

from flatland2d import SensorHandle, UsageError
from flatland2d.sweep import SweepRun
from flatland_gym.policy import Policy
from flatland_server import Float32Array


def drive(run: SweepRun, file: str) -> None:
    """A controller of sweeps: acts in the policy's own period until the run is over.

    Args:
        run: has a goal, and a robot with a lidar that has as many beams as the policy's.
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
        action = policy.drive(lidar.read(), robot.pose, robot.local_velocity, run.goal)
        robot.command(*action)
        run.step(policy.period)


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
