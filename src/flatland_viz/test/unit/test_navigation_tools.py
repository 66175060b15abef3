"""rviz's navigation tools in the toolbar."""

import pytest

from flatland_viz.navigation_tools import NAVIGATION_TOOLS, goal_topics, show_tools, wanted_tools

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

    def setDescription(self, text):
        self.description = text

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


R1_GOAL = GOAL._replace(topic="/r1/move_base_simple/goal")
R2_GOAL = GOAL._replace(topic="/r2/move_base_simple/goal")


@pytest.mark.parametrize(
    ("subscribed", "namespace", "wanted"),
    [
        ([R1_GOAL, R2_GOAL], "r1", [R1_GOAL]),
        ([R1_GOAL, R2_GOAL], "", []),  # nothing tells which
        ([R1_GOAL], "", [R1_GOAL]),
        ([R1_GOAL], "r2", []),
        ([R1_GOAL, GOAL], "r1", [R1_GOAL]),
        ([R1_GOAL, GOAL], "", [GOAL]),
        ([GOAL], "r1", [GOAL]),  # a planner for all robots
    ],
)
def test_goals_go_to_the_selected_robot(subscribed, namespace, wanted):
    topics = goal_topics([tool.topic for tool in subscribed] + ["/r1/scan"])
    assert wanted_tools(topics, namespace) == wanted


def test_a_tool_follows_the_selection():
    manager = ToolManager(GOAL.kind)
    show_tools(manager, [R1_GOAL])
    show_tools(manager, [R2_GOAL])
    assert [tool.topic for tool in manager.tools] == [R2_GOAL.topic]


def test_tools_are_added_and_removed_and_others_stay():
    manager = ToolManager("flatland_viz/Interact", POSE.kind)
    show_tools(manager, [GOAL])

    assert [tool.kind for tool in manager.tools] == ["flatland_viz/Interact", GOAL.kind]
    assert manager.tools[1].topic == "/move_base_simple/goal"
