"""The displays of the window, and how they change with the world."""

from flatland_viz.displays import Shown, changes, laser_scans, wanted

DEBUG = "/flatland_server/debug"


def test_all_layers_share_a_display_and_each_scan_has_one():
    shown = wanted(DEBUG, ["/front/scan", "/scan"])

    assert [(one.name, one.kind, one.topic) for one in shown] == [
        ("layers", "flatland_viz/Walls", "/flatland_server/debug/walls"),
        ("models", "flatland_viz/Bodies", "/flatland_server/debug/models"),
        ("front/scan", "flatland_viz/Scan", "/front/scan"),
        ("scan", "flatland_viz/Scan", "/scan"),
    ]


def test_an_empty_world_has_the_displays_of_layers_and_models():
    shown = wanted(DEBUG, [])

    assert [one.name for one in shown] == ["layers", "models"]


def test_a_server_in_a_namespace_has_its_own_topics():
    shown = wanted("/a/flatland_server/debug", [])

    assert [one.topic for one in shown] == [
        "/a/flatland_server/debug/walls",
        "/a/flatland_server/debug/models",
    ]


def test_laser_scans_are_found_among_all_topics():
    published = [
        ("/scan", "sensor_msgs/LaserScan"),
        ("/clock", "rosgraph_msgs/Clock"),
        ("/camera/scan", "sensor_msgs/LaserScan"),
        ("/points", "sensor_msgs/PointCloud2"),
    ]

    assert laser_scans(published) == ["/camera/scan", "/scan"]


def test_laser_scans_are_in_natural_order():
    published = [(f"/r{number}/scan", "sensor_msgs/LaserScan") for number in (10, 9, 2)]

    assert laser_scans(published) == ["/r2/scan", "/r9/scan", "/r10/scan"]


def test_a_new_robot_adds_its_scan_and_changes_no_other_display():
    before = wanted(DEBUG, ["/scan"])
    after = wanted(DEBUG, ["/robot2/scan", "/scan"])

    gone, new = changes(before, after)

    assert gone == []
    assert new == [Shown("robot2/scan", "flatland_viz/Scan", "/robot2/scan")]


def test_the_scan_of_a_deleted_robot_is_removed():
    before = wanted(DEBUG, ["/robot2/scan", "/scan"])
    after = wanted(DEBUG, ["/scan"])

    assert changes(before, after) == (
        [Shown("robot2/scan", "flatland_viz/Scan", "/robot2/scan")],
        [],
    )


def test_equal_displays_stay():
    shown = wanted(DEBUG, ["/scan"])

    assert changes(shown, list(shown)) == ([], [])
