"""Agents of other programs, which a Pedestrian follows."""

import math
from dataclasses import dataclass
from typing import Any, Iterator

from flatland_server import Point, yaw_of

_PATIENCE = 1.0
"""The time [s] for which an agent is taken to walk on after its last state."""

FARTHEST = 5e4
"""The largest coordinate [m] and speed [m/s] of an agent that is followed."""


@dataclass
class Agent:
    """An agent in the world's frame.

    Attributes:
        x, y: its position [m].
        vx, vy: its velocity [m/s].
        age: the time since its last state [s].
    """

    x: float
    y: float
    vx: float
    vy: float
    age: float = 0.0

    @property
    def is_valid(self) -> bool:
        """Whether its numbers are finite, and none is too large."""
        return all(abs(value) < FARTHEST for value in (self.x, self.y, self.vx, self.vy))

    @property
    def point(self) -> Point:
        """Its position [m]."""
        return self.x, self.y

    def advance(self, dt: float) -> None:
        """Lets it walk on for `dt` seconds, unless its last state is too old."""
        if self.age < _PATIENCE:
            self.x += self.vx * dt
            self.y += self.vy * dt
            self.age += dt


def from_odometry(message: Any) -> Agent:
    """The agent of an Odometry: a pose in the world, and a velocity in the agent's frame."""
    place, velocity = message.pose.pose, message.twist.twist.linear
    yaw = yaw_of(place.orientation)
    cos, sin = math.cos(yaw), math.sin(yaw)
    vx, vy = cos * velocity.x - sin * velocity.y, sin * velocity.x + cos * velocity.y
    return Agent(place.position.x, place.position.y, vx, vy)


def from_agent_states(message: Any, id: str) -> Iterator[Agent]:
    """The agents of an id among the AgentStates of pedsim_msgs."""
    for state in message.agent_states:
        if str(state.id) == id:
            place, velocity = state.pose.position, state.twist.linear
            yield Agent(place.x, place.y, velocity.x, velocity.y)
