"""Mirror images of observations and actions, in which left and right change places."""

from typing import Optional

import numpy as np

from flatland_gym.navigation import Navigation
from flatland_gym.observations import mirror_signs
from flatland_gym.robot import Robot
from flatland_server import Float32Array


class Mirror:
    """The mirror images of a robot's experience.

    The mirror image of a motion is a motion as well: a learner has twice the experience from the
    same steps (Abdolhosseini et al., "On learning symmetric locomotion", MIG 2019).

    Args:
        robot: with `mirrored_beams`.
        neighbors: in an observation.
    """

    def __init__(self, robot: Robot, neighbors: int) -> None:
        self._signs = mirror_signs(robot.beams, robot.velocity_limits, neighbors)
        self._order = np.arange(len(self._signs))
        self._order[: robot.beams] = robot.mirrored_beams
        self._action_signs = np.full(len(robot.action_limits), -1.0, np.float32)
        self._action_signs[0] = 1.0  # the speed forwards

    @classmethod
    def of(cls, navigation: Navigation) -> "Optional[Mirror]":
        """That of an environment; None if the robot's lidar does not look to both sides alike."""
        robot = navigation.robot
        return cls(robot, navigation.settings.neighbors) if robot.mirrored_beams else None

    def observations(self, rows: Float32Array) -> Float32Array:
        """The mirror images of flat observations, shape (n, size)."""
        images: Float32Array = rows[:, self._order]
        images *= self._signs
        return images

    def turn(self, observations: Float32Array, actions: Float32Array) -> None:
        """Replaces rows by their mirror images."""
        observations[:] = self.observations(observations)
        actions *= self._action_signs
