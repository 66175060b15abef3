"""The models in the world, as the server describes them (flatland_msgs/ModelList)."""

import re
from typing import Any, Dict, Iterable, List, NamedTuple, Tuple

from flatland_teleop.natural_order import natural_key
from flatland_viz.displays import SCAN_TYPE


class Topic(NamedTuple):
    """A topic of a model."""

    name: str
    type: str
    is_published: bool
    """True if the server publishes it; otherwise the server subscribes."""
    plugin: str


class Model(NamedTuple):
    """A model."""

    name: str
    namespace: str
    file: str
    """Absolute path of its file; empty if there is none."""
    plugins: Tuple[str, ...]
    """Its plugins, each as `name (Type)`."""
    failed: Tuple[str, ...]
    """The names of the plugins that were switched off after a failure."""
    topics: Tuple[Topic, ...]
    size: float
    """The longest side of the boxes around its bodies [m]."""
    steers: bool
    """True if its commands have a steering angle instead of a yaw rate."""

    @property
    def command_topic(self) -> str:
        """The topic of its velocity commands; empty if it has no drive."""
        for topic in self.topics:
            if not topic.is_published and topic.type == "geometry_msgs/Twist":
                return topic.name
        return ""


def models_of(message: Any) -> Dict[str, Model]:
    """The models of a flatland_msgs/ModelList by name, in natural order."""
    models = {info.name: _model(info) for info in message.models}
    return {name: models[name] for name in sorted(models, key=natural_key)}


def _model(info: Any) -> Model:
    sides = [
        side for body in info.bodies for side in (body.max_x - body.min_x, body.max_y - body.min_y)
    ]
    return Model(
        info.name,
        info.ns,
        info.yaml_path,
        tuple(f"{plugin.name} ({plugin.type})" for plugin in info.plugins),
        tuple(plugin.name for plugin in info.plugins if plugin.has_failed),
        tuple(
            Topic(topic.name, topic.type, topic.is_published, plugin.name)
            for plugin in info.plugins
            for topic in plugin.topics
        ),
        max(sides, default=0.0),
        any(plugin.type.endswith("TricycleDrive") for plugin in info.plugins),
    )


def topic_owners(models: Dict[str, Model]) -> Dict[str, str]:
    """The models that publish laser scans, and robots, by their topics and by namespaces."""
    robots = {
        model.command_topic.rpartition("/")[0]: model.name
        for model in models.values()
        if model.command_topic
    }
    scans = {
        topic.name: model.name
        for model in models.values()
        for topic in model.topics
        if topic.is_published and topic.type == SCAN_TYPE
    }
    return {**robots, **scans}


def free_name(wanted: str, taken: Iterable[str]) -> str:
    """A name that is not taken: the wanted one with the next number after the highest.

    r2 becomes r3 if r2 is the highest of the r's, and box becomes box_2.
    """
    taken_names = set(taken)
    if wanted not in taken_names:
        return wanted
    match = re.fullmatch(r"(.*?)([0-9]+)", wanted)
    stem, number = (match[1], int(match[2])) if match else (f"{wanted}_", 1)
    number += 1
    while f"{stem}{number}" in taken_names:
        number += 1
    return f"{stem}{number}"


def namespace_of_copy(model: Model, name: str, models: Iterable[Model]) -> str:
    """The namespace of a copy, in which it shares no topics and frames with any of the models.

    Args:
        model: the original. Without plugins, hence topics and frames, it needs no namespace.
        name: of the copy, from which its namespace follows if the original has none.
        models: all models in the world.
    """
    if not model.plugins and not model.namespace:
        return ""
    wanted = model.namespace or re.sub(r"\W", "_", name, flags=re.ASCII)
    if not wanted[0].isalpha():
        wanted = f"m{wanted}"  # as ROS demands of names
    return free_name(wanted, [other.namespace for other in models])


def sorted_topics(topics: Iterable[Topic]) -> List[Topic]:
    """Topics in natural order, published ones first."""
    return sorted(topics, key=lambda topic: (not topic.is_published, natural_key(topic.name)))
