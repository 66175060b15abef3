"""The topics that robots take commands from, as the master knows them."""

from typing import Any, List, NamedTuple, Sequence, Tuple

from flatland_teleop.natural_order import natural_key

TWIST = "geometry_msgs/Twist"


class RobotTopic(NamedTuple):
    """A topic of commands.

    Attributes:
        name: the topic's name.
        publishers: other nodes that publish on it.
    """

    name: str
    publishers: Tuple[str, ...] = ()


def robot_topics(
    system_state: Sequence[Any], topic_types: Sequence[Sequence[str]], node: str
) -> List[RobotTopic]:
    """All topics of type geometry_msgs/Twist with a subscriber, robot2 before robot10.

    Args:
        system_state: publishers, subscribers and services, from the master's getSystemState.
        topic_types: from its getTopicTypes.
        node: the name of this node, left out of the publishers.
    """
    publishers, subscribers = dict(system_state[0]), system_state[1]
    twists = {topic for topic, kind in topic_types if kind == TWIST}
    return [
        RobotTopic(topic, tuple(sorted(set(publishers.get(topic, ())) - {node})))
        for topic, _ in sorted(subscribers, key=lambda entry: natural_key(entry[0]))
        if topic in twists
    ]


def next_topic(topics: Sequence[RobotTopic], current: str) -> str:
    """The topic after this one, cyclically; this one if there is no other."""
    names = [topic.name for topic in topics]
    if not names:
        return current
    return names[(names.index(current) + 1) % len(names)] if current in names else names[0]
