"""rviz's navigation tools in the toolbar."""

import pytest

from flatland_viz.navigation_tools import NAVIGATION_TOOLS, show_tools, wanted_tools

POSE, GOAL = NAVIGATION_TOOLS


class Tool:
    """A tool with the property "Topic"."""

    def __init__(self, kind):
        self.kind, self.topic = kind, ""

    def getClassId(self):
        return self.kind

    def getPropertyContainer(self):
        return self

    def subProp(self, name):
        assert name == "Topic"
        return self

    def setValue(self, topic):
        self.topic = topic


class ToolManager:
    """rviz's tool manager, with these tools."""

    def __init__(self, *kinds):
        self.tools = [Tool(kind) for kind in kinds]

    def numTools(self):
        return len(self.tools)

    def getTool(self, index):
        return self.tools[index]

    def addTool(self, kind):
        self.tools.append(Tool(kind))
        return self.tools[-1]

    def removeTool(self, index):
        del self.tools[index]


@pytest.mark.parametrize(
    ("subscribed", "wanted"),
    [
        (["/scan"], []),
        (["/move_base_simple/goal", "/scan"], [GOAL]),
        (["/move_base_simple/goal", "/initialpose"], [POSE, GOAL]),
    ],
)
def test_a_tool_is_wanted_if_its_topic_has_subscribers(subscribed, wanted):
    assert wanted_tools(subscribed) == wanted


def test_tools_are_added_and_removed_and_others_stay():
    manager = ToolManager("flatland_viz/Interact", POSE.kind)
    show_tools(manager, [GOAL])

    assert [tool.kind for tool in manager.tools] == ["flatland_viz/Interact", GOAL.kind]
    assert manager.tools[1].topic == "/move_base_simple/goal"
