"""Drives Flatland's robots to goals: a planner, a path follower, and their node.

`planner`, `follower`, `obstacles` and `navigator` need no ROS; they run in a `Simulation` as well
as in the node `navigator_node`, which has the interface of move_base.
"""
