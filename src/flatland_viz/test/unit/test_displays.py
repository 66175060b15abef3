"""Which displays the window has, and which of them come and go."""

from flatland_viz.displays import Shown, changes, laser_scans, wanted

DEBUG = "/flatland_server/debug"
HANDLES = "/interactive_model_markers/update"
LISTED = ["layer/map", "layer/upper/walls", "model/robot", "model/fleet/box"]


def test_each_layer_and_each_scan_has_a_display():
    shown = wanted(DEBUG, HANDLES, LISTED, ["/front/scan", "/scan"])

    assert [(one.name, one.kind, one.topic) for one in shown] == [
        ("layer/map", "rviz/MarkerArray", "/flatland_server/debug/layer/map"),
        ("layer/upper/walls", "rviz/MarkerArray", "/flatland_server/debug/layer/upper/walls"),
        ("models", "rviz/MarkerArray", "/flatland_server/debug/models"),
        ("drag and turn", "rviz/InteractiveMarkers", "/interactive_model_markers/update"),
        ("front/scan", "rviz/LaserScan", "/front/scan"),
        ("scan", "rviz/LaserScan", "/scan"),
    ]


def test_models_are_waited_for_in_an_empty_world():
    shown = wanted(DEBUG, HANDLES, [], [])

    assert [one.name for one in shown] == ["models", "drag and turn"]


def test_a_server_in_a_namespace_has_its_own_topics():
    shown = wanted("/a/flatland_server/debug", "/a/handles", ["layer/map"], [])

    assert [one.topic for one in shown] == [
        "/a/flatland_server/debug/layer/map",
        "/a/flatland_server/debug/models",
        "/a/handles",
    ]


def test_laser_scans_are_found_among_all_topics():
    published = [
        ("/scan", "sensor_msgs/LaserScan"),
        ("/clock", "rosgraph_msgs/Clock"),
        ("/camera/scan", "sensor_msgs/LaserScan"),
        ("/points", "sensor_msgs/PointCloud2"),
    ]

    assert laser_scans(published) == ["/camera/scan", "/scan"]


def test_a_robot_that_comes_adds_its_scan_and_touches_no_other_display():
    before = wanted(DEBUG, HANDLES, LISTED, ["/scan"])
    after = wanted(DEBUG, HANDLES, [*LISTED, "model/robot2"], ["/robot2/scan", "/scan"])

    gone, new = changes(before, after)

    assert gone == []
    assert new == [Shown("robot2/scan", "rviz/LaserScan", "/robot2/scan")]


def test_a_robot_that_goes_takes_its_scan_with_it():
    before = wanted(DEBUG, HANDLES, LISTED, ["/robot2/scan", "/scan"])
    after = wanted(DEBUG, HANDLES, LISTED, ["/scan"])

    assert changes(before, after) == ([Shown("robot2/scan", "rviz/LaserScan", "/robot2/scan")], [])


def test_another_world_replaces_the_layers_alone():
    before = wanted(DEBUG, HANDLES, ["layer/map"], ["/scan"])
    after = wanted(DEBUG, HANDLES, ["layer/hall"], ["/scan"])

    gone, new = changes(before, after)

    assert [one.name for one in gone] == ["layer/map"]
    assert [one.name for one in new] == ["layer/hall"]


def test_nothing_changes_when_nothing_has_changed():
    shown = wanted(DEBUG, HANDLES, LISTED, ["/scan"])

    assert changes(shown, list(shown)) == ([], [])
