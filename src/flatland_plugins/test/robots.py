"""The robots of a rostest: poses, and names of topics and frames in their namespaces."""

from typing import Any, NamedTuple, Tuple, Type

from readings import turned


class Robot(NamedTuple):
    """A model and its spawn pose [m, m, rad]."""

    name: str
    namespace: str
    x: float
    y: float
    yaw: float

    def topic(self, name: str) -> str:
        """A topic of this robot."""
        return f"/{self.namespace}/{name}" if self.namespace else f"/{name}"

    def frame(self, name: str) -> str:
        """The name of a frame; "{ns}" at its start stands for the robot's namespace."""
        return name.format(ns=f"{self.namespace}_" if self.namespace else "")

    def at(self, x: float, y: float) -> Tuple[float, float]:
        """A point of the robot's frame in the world's frame, at the spawn pose."""
        return turned((x, y), self.yaw, (self.x, self.y))


class Topic(NamedTuple):
    """A topic that a plugin publishes: the rate in Hz, frames as `Robot.frame` takes them."""

    name: str
    type: Type[Any]
    rate: float = 200.0
    frame: str = ""
    child_frame: str = ""


class Frame(NamedTuple):
    """A transform that a plugin sends: the rate in Hz."""

    parent: str
    child: str
    rate: float = 200.0
