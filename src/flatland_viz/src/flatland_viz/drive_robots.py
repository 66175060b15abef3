"""The robots that can be driven."""

from typing import Iterable, List, NamedTuple

from flatland_viz.model_list import Model

_STEERS = "(TricycleDrive)"


class Robot(NamedTuple):
    """A model that can be driven."""

    name: str
    topic: str
    """The topic of its commands, geometry_msgs/Twist."""
    steers: bool
    """True if commands have a steering angle instead of a yaw rate."""


def robots_of(models: Iterable[Model]) -> List[Robot]:
    """The models that subscribe to commands."""
    return [
        Robot(model.name, model.command_topic, any(_STEERS in plugin for plugin in model.plugins))
        for model in models
        if model.command_topic
    ]
