"""What a robot of a rostest is: where it stands, and what becomes of names in its namespace."""

from typing import Any, NamedTuple, Tuple, Type

from readings import turned


class Robot(NamedTuple):
    """A model, and where it is spawned [m, m, rad]."""

    name: str
    namespace: str
    x: float
    y: float
    yaw: float

    def topic(self, name: str) -> str:
        """A topic of this robot."""
        return f"/{self.namespace}/{name}" if self.namespace else f"/{name}"

    def frame(self, name: str) -> str:
        """A frame; "{ns}" at its beginning says that it is the robot's own."""
        return name.format(ns=f"{self.namespace}_" if self.namespace else "")

    def at(self, x: float, y: float) -> Tuple[float, float]:
        """Where a point of the robot's own frame is in the world, as it is spawned."""
        return turned((x, y), self.yaw, (self.x, self.y))


class Topic(NamedTuple):
    """What a plugin publishes: the rate in Hz, frames as `Robot.frame` takes them."""

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
