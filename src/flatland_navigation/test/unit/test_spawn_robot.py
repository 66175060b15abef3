"""The node spawn_robot: its warning about a second sender of map -> odom."""

import pytest
import rospy
from flatland_msgs.srv import SpawnModelResponse
from geometry_msgs.msg import Pose2D

from flatland_navigation import spawn_robot_node


@pytest.mark.parametrize("localiser", ["amcl", ""])
@pytest.mark.parametrize("map_to_odom", [True, False])
def test_a_server_that_sends_map_to_odom_beside_a_localiser_is_warned_about(
    monkeypatch, localiser, map_to_odom
):
    params = {
        "~model": "robot.model.yaml",
        "~localiser": localiser,
        "/flatland_server/map_to_odom": map_to_odom,
    }
    warnings = []
    monkeypatch.setattr(rospy, "get_param", lambda name, default=None: params.get(name, default))
    monkeypatch.setattr(rospy, "ServiceProxy", lambda *_: lambda *_: SpawnModelResponse(True, ""))
    monkeypatch.setattr(rospy, "logwarn", lambda form, *values: warnings.append(form % values))

    spawn_robot_node.spawn("r1", Pose2D())

    assert len(warnings) == (localiser == "amcl" and map_to_odom)
    assert all(
        "r1: both amcl" in each and "map_to_odom:=false" in each and "navigator:=waypoints" in each
        for each in warnings
    )
