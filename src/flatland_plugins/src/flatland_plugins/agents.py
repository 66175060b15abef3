"""Agents of other programs, which a Pedestrian follows."""

import math
from typing import Any, Iterator, NamedTuple

from flatland_server import Point, yaw_of

FARTHEST = 5e4
"""The largest coordinate [m] and speed [m/s] of an agent that is followed."""


class Agent(NamedTuple):
    """An agent in the world's frame: its position [m] and velocity [m/s]."""

    point: Point
    velocity: Point

    @property
    def is_valid(self) -> bool:
        """True if its numbers are finite, and none is too large."""
        return all(abs(value) < FARTHEST for value in (*self.point, *self.velocity))


def from_odometry(message: Any) -> Agent:
    """The agent of an Odometry: a pose in the world, and a velocity in the agent's frame."""
    place, velocity = message.pose.pose, message.twist.twist.linear
    yaw = yaw_of(place.orientation)
    cos, sin = math.cos(yaw), math.sin(yaw)
    world_velocity = cos * velocity.x - sin * velocity.y, sin * velocity.x + cos * velocity.y
    return Agent((place.position.x, place.position.y), world_velocity)


def from_agent_states(message: Any, id: str) -> Iterator[Agent]:
    """The agents of an id among the AgentStates of pedsim_msgs."""
    for state in message.agent_states:
        if str(state.id) == id:
            place, velocity = state.pose.position, state.twist.linear
            yield Agent((place.x, place.y), (velocity.x, velocity.y))
