"""rviz's tools for navigation, in the toolbar while their topics have subscribers."""

from typing import Any, Iterable, List, NamedTuple


class NavigationTool(NamedTuple):
    """A tool that publishes to a topic."""

    kind: str
    """Its class in rviz."""
    topic: str


NAVIGATION_TOOLS = (
    NavigationTool("rviz/SetInitialPose", "/initialpose"),
    NavigationTool("rviz/SetGoal", "/move_base_simple/goal"),
)


def wanted_tools(subscribed: Iterable[str]) -> List[NavigationTool]:
    """The tools of use.

    Args:
        subscribed: the topics that have subscribers, by their absolute names.
    """
    topics = set(subscribed)
    return [tool for tool in NAVIGATION_TOOLS if tool.topic in topics]


def show_tools(manager: Any, wanted: List[NavigationTool]) -> None:
    """Adds and removes navigation tools so that the toolbar has just the wanted ones.

    Args:
        manager: rviz's tool manager.
        wanted: of `NAVIGATION_TOOLS`.
    """
    present = [manager.getTool(index).getClassId() for index in range(manager.numTools())]
    kinds = [tool.kind for tool in wanted]
    known = [tool.kind for tool in NAVIGATION_TOOLS]
    for index in reversed(range(len(present))):
        if present[index] in known and present[index] not in kinds:
            manager.removeTool(index)
    for tool in wanted:
        if tool.kind not in present:
            added = manager.addTool(tool.kind)
            added.getPropertyContainer().subProp("Topic").setValue(tool.topic)
