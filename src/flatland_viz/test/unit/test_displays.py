"""The displays of the window, and how they change with the world."""

from flatland_viz.displays import Shown, changes, color_of, of_topics, wanted

DEBUG = "/flatland_server/debug"


def scans(*topics):
    return of_topics((topic, "sensor_msgs/LaserScan") for topic in topics)


def test_all_layers_share_a_display_and_each_scan_has_one():
    shown = wanted(DEBUG, scans("/front/scan", "/scan"))

    assert [(one.name, one.kind, one.topic) for one in shown] == [
        ("layers", "flatland_viz/Walls", "/flatland_server/debug/walls"),
        ("models", "flatland_viz/Bodies", "/flatland_server/debug/models"),
        ("front/scan", "flatland_viz/Scan", "/front/scan"),
        ("scan", "flatland_viz/Scan", "/scan"),
    ]
    namespaced = [one.topic for one in wanted("/a/flatland_server/debug", [])]
    assert namespaced == ["/a/flatland_server/debug/walls", "/a/flatland_server/debug/models"]


def test_scans_plans_and_goals_are_listed_in_natural_order():
    poses, paths = "geometry_msgs/PoseStamped", "nav_msgs/Path"
    published = [
        ("/r10/scan", "sensor_msgs/LaserScan"),
        ("/r2/scan", "sensor_msgs/LaserScan"),
        ("/clock", "rosgraph_msgs/Clock"),
        ("/r2/move_base/plan", paths),
        ("/r2/move_base/current_goal", poses),
        ("/r2/move_base_simple/goal", poses),  # the same goals
        ("/r10/move_base_simple/goal", poses),
        ("/r10/pose", poses),
    ]

    assert [(one.kind.partition("/")[2], one.topic) for one in of_topics(published)] == [
        ("Pose", "/r2/move_base/current_goal"),
        ("Path", "/r2/move_base/plan"),
        ("Scan", "/r2/scan"),
        ("Pose", "/r10/move_base_simple/goal"),
        ("Scan", "/r10/scan"),
    ]


def test_scans_are_shown_with_the_transforms_that_the_window_has():
    published = [
        ("/tf", "tf2_msgs/TFMessage"),
        ("/r1/tf", "tf2_msgs/TFMessage"),
        *((f"{robot}/scan", "sensor_msgs/LaserScan") for robot in ("", "/r1", "/r1/front", "/r2")),
    ]

    assert [one.topic for one in of_topics(published)] == ["/r2/scan", "/scan"]
    assert [one.topic for one in of_topics(published, "/r1/tf")] == ["/r1/front/scan", "/r1/scan"]
    assert [one.topic for one in of_topics(published[2:], "/a/tf")] == [
        *("/r1/front/scan", "/r1/scan", "/r2/scan", "/scan")
    ]


def test_a_plan_has_the_colour_of_the_robot_in_its_namespace():
    colors = {"/r2": "#00ff00", "/r2/rear_scan": "#0000ff"}

    assert color_of("/r2/move_base/plan", colors) == "#00ff00"
    assert color_of("/r2/rear_scan", colors) == "#0000ff"
    assert color_of("/r22/move_base/plan", colors) == ""
    assert color_of("/move_base/plan", {**colors, "": "#ff0000"}) == "#ff0000"


def test_robots_come_and_go_with_their_scans_and_other_displays_stay():
    one, two = wanted(DEBUG, scans("/scan")), wanted(DEBUG, scans("/robot2/scan", "/scan"))
    scan = Shown("robot2/scan", "flatland_viz/Scan", "/robot2/scan")

    assert changes(one, two) == ([], [scan])
    assert changes(two, one) == ([scan], [])
    assert changes(one, list(one)) == ([], [])
