"""rviz's tools for navigation, in the toolbar while their topics have subscribers."""

from typing import Any, Collection, FrozenSet, Iterable, List, NamedTuple


class NavigationTool(NamedTuple):
    """A tool that publishes to a topic."""

    kind: str
    """Its class in rviz."""
    topic: str


NAVIGATION_TOOLS = (
    NavigationTool("rviz/SetInitialPose", "/initialpose"),
    NavigationTool("rviz/SetGoal", "/move_base_simple/goal"),
)


def goal_topics(subscribed: Iterable[str]) -> FrozenSet[str]:
    """The topics of navigation among those that have subscribers, in any namespace."""
    ends = tuple(tool.topic for tool in NAVIGATION_TOOLS)
    return frozenset(topic for topic in subscribed if topic.endswith(ends))


def wanted_tools(subscribed: Collection[str], namespace: str = "") -> List[NavigationTool]:
    """The tools of use, with the topics of the selected robot.

    Without one, goals go to robots without a namespace, or to the only one that takes them.

    Args:
        subscribed: the topics that have subscribers, by their absolute names.
        namespace: of the selected robot; empty if it has none.
    """
    wanted = []
    for tool in NAVIGATION_TOOLS:
        others = [topic for topic in subscribed if topic.endswith(tool.topic)]
        topics = [f"/{namespace}{tool.topic}"] if namespace else others if len(others) == 1 else []
        topic = next((each for each in (*topics, tool.topic) if each in subscribed), None)
        if topic is not None:
            wanted.append(tool._replace(topic=topic))
    return wanted


def show_tools(manager: Any, wanted: List[NavigationTool]) -> None:
    """Adds and removes navigation tools so that the toolbar has just the wanted ones.

    Args:
        manager: rviz's tool manager.
        wanted: the tools to show, with their topics.
    """
    present = [manager.getTool(index).getClassId() for index in range(manager.numTools())]
    kinds = [tool.kind for tool in wanted]
    known = [tool.kind for tool in NAVIGATION_TOOLS]
    for index in reversed(range(len(present))):
        if present[index] in known and present[index] not in kinds:
            manager.removeTool(index)
    for tool in wanted:
        if tool.kind not in present:
            manager.addTool(tool.kind)
    topics = {tool.kind: tool.topic for tool in wanted}
    for index in range(manager.numTools()):
        shown = manager.getTool(index)
        if shown.getClassId() in topics:
            topic = topics[shown.getClassId()]
            shown.getPropertyContainer().subProp("Topic").setValue(topic)
            shown.setDescription(f"Publishes on {topic}.")
