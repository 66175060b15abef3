"""The window's scene with several robots and no localiser: scans, the mouse, names, selection."""

import math
from pathlib import Path

import numpy as np
import pytest
from gui_screen import FIRST_ROBOT
from scene_window import CRATE, SceneWindow
from screen_pictures import near

pytestmark = pytest.mark.slow

DOOR = Path(__file__).resolve().parents[3] / "examples/automatic_door/door.model.yaml"
WORLD = """
properties: {{}}
layers: [{{name: room, map: {room}, color: [0.4, 0.4, 0.4, 1]}}]
models:
  - {{name: r10, namespace: r10, pose: [-3, 0, 0], model: {robot}}}
  - {{name: r2, namespace: r2, pose: [0, -1.5, 1.57], model: {robot}}}
  - {{name: crate, pose: [1.5, 1.5, 0], model: {box}}}
"""
GOALS = """
import rospy
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path
rospy.init_node("goals", disable_rostime=True)
def note(goal, robot):
    print(robot, "goes to", goal.pose.position, flush=True)
    plan = Path(header=goal.header, poses=[PoseStamped(), PoseStamped()])
    plan.poses[0].pose.position.x, plan.poses[1].pose.position.x = -1.0, 1.0
    for pose in plan.poses:
        pose.pose.position.y, pose.pose.orientation.w = goal.pose.position.y + 1.0, 1.0
    plans[robot].publish(plan)
plans = {}
for robot in ("/r2", "/r10"):
    plans[robot] = rospy.Publisher(robot + "/move_base/plan", Path, queue_size=1, latch=True)
    rospy.Subscriber(robot + "/move_base_simple/goal", PoseStamped, note, robot)
rospy.spin()
"""
LOCALISER = """
import rospy
from geometry_msgs.msg import TransformStamped
from tf2_msgs.msg import TFMessage
rospy.init_node("localiser")
publisher = rospy.Publisher("/tf", TFMessage, queue_size=1)
transform = TransformStamped(child_frame_id="r10_odom")
transform.header.frame_id = "map"
transform.transform.translation.x = transform.transform.rotation.w = 1.0
while not rospy.is_shutdown():
    transform.header.stamp = rospy.Time.now()
    publisher.publish(TFMessage([transform]))
    rospy.sleep(0.05)
"""
"""A program that believes that r10 is a metre further along x than it is."""


@pytest.fixture(scope="module")
def window(screen, ros, waiting, office, tmp_path_factory):
    """The window, with a server that does not publish map -> odom."""
    world = tmp_path_factory.mktemp("world") / "world.yaml"
    names = {
        "room": office.parent / "test_room" / "room.yaml",
        "robot": office / "turtlebot.model.yaml",
        "box": office / "box.model.yaml",
    }
    world.write_text(WORLD.format(**names))
    ros.start_server(world)
    ros.start_window()
    return SceneWindow(screen, ros, waiting, screen.wait_for_window("Flatland - .*"))


def put_back(window):
    window.ros.call("/move_model", name="crate", pose={"x": CRATE[0], "y": CRATE[1], "theta": 0.0})


def is_colored(pixels):
    return pixels.max(axis=-1) - pixels.min(axis=-1) > 60


def scans(window, name):
    """The numbers of scan pixels in the view, and of those on the free floor."""
    pixels = window.picture(name)
    free = pixels.copy()
    for x, y in ((-3.0, 0.0), (0.0, -1.5), CRATE):
        free[window.map.around(x, y, 0.75)] = 0
    return is_colored(pixels[window.view]).sum(), is_colored(window.inside(free)).sum()


def test_scans_show_where_no_localiser_runs(window):
    """Robots are placed by ground truth, in this window alone."""

    def shown():
        number, astray = scans(window, "scans")
        return number > 300 and astray == 0

    window.waiting(shown, "scans on the walls", 30)
    assert not {"r2_odom", "r10_odom"} & window.transforms().keys()
    # While a robot turns, they stay on the walls.
    turn = {"linear": {"x": 0.0}, "angular": {"z": 1.0}}
    drive = window.ros.start(
        "rostopic", "pub", "-r", "10", "/r2/cmd_vel", "geometry_msgs/Twist", str(turn)
    )
    window.waiting(lambda: abs(window.ros.pose("r2")[2] - 1.57) > 0.5, "the robot to turn")
    assert scans(window, "turning")[1] == 0
    window.ros.end(drive)
    window.ros.call("/move_model", name="r2", pose={"x": 0.0, "y": -1.5, "theta": 1.57})


def test_a_drag_moves_the_map_and_the_wheel_zooms_at_the_cursor(window):
    crate = window.place_of_crate("mouse")
    by = np.subtract(window.map.pixel(-0.2, -0.4), window.map.pixel(-1.0, 0.0))
    begin = window.map.pixel(-1.0, 0.0)
    window.drag(begin, np.add(begin, by))
    window.waiting(
        lambda: math.dist(window.place_of_crate("panned"), np.add(crate, by)) < 3, "the map to move"
    )

    at = np.array(window.place_of_crate("panned"))
    cursor = np.add(
        at, (-0.7 * window.map.scale, -0.5 * window.map.scale)
    )  # beside the crate: nothing covers it
    window.screen.move(cursor)
    window.screen.xdotool("click", "--repeat", 5, "--delay", 30, 4)
    expected = cursor + 1.12**5 * (at - cursor)
    window.waiting(
        lambda: math.dist(window.place_of_crate("zoomed"), expected) < 3, "the map to zoom"
    )

    before = window.show_all().pixel(*CRATE)
    assert math.dist(before, crate) < 3


def test_a_drag_with_ctrl_rotates_the_map_about_the_middle(window):
    middle = np.array(window.map.pixel(0.0, 0.0))
    crate = np.subtract(window.place_of_crate("rotated"), middle)
    reach = 2.8 * window.map.scale
    begin = np.add(middle, (reach, 0))
    angle = math.radians(30)
    end = np.add(middle, (reach * math.cos(angle), -reach * math.sin(angle)))  # to the left
    window.drag(begin, end, "ctrl")

    turn = [[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]]
    expected = np.add(middle, np.dot(turn, crate))
    window.waiting(
        lambda: math.dist(window.place_of_crate("rotated"), expected) < 6, "the map to rotate"
    )
    window.show_all()


def test_goals_go_to_the_selected_robot(window):
    """2D Nav Goal is in the toolbar, by its key too, while a robot takes goals and is selected."""

    def toolbar():
        rows, columns = window.view
        return window.picture("tools")[: rows.start, columns]

    before = toolbar()
    subscriber = window.ros.start("/usr/bin/python3", "-c", GOALS)
    for robot, at, y in (("r2", (0.0, -1.5), -1.0), ("r10", (-3.0, 0.0), 0.0)):
        window.click(*at)
        window.waiting(lambda: (toolbar() != before).any(), "the tool")
        window.waiting(lambda r=robot: f"/{r}/scan" in window.subscriptions(), "the selection")
        window.screen.move(window.map.pixel(0.0, 1.0))
        window.screen.key("g")
        window.drag(window.map.pixel(1.0, y), window.map.pixel(2.0, y))
        goal = f"/{robot} goes to x: "
        window.waiting(lambda goal=goal: goal in window.ros.log(subscriber), "its goal")
    # The last plan and goal are drawn in the colour of their robot.
    plan, arrow = window.map.around(0.0, 1.0, 0.2), window.map.around(1.3, 0.0, 0.4)
    drawn = lambda place: near(window.picture("goal")[place], FIRST_ROBOT, 60).sum()  # noqa: E731
    for place in (plan, arrow):
        window.waiting(lambda place=place: drawn(place) > 20, "the plan and the goal")
    window.click(4.0, 0.5)
    window.ros.end(subscriber)
    window.waiting(lambda: drawn(plan) == 0, "the plan to go")
    window.waiting(lambda: (toolbar() == before).all(), "the tool to go")


def plate(window, name, x, y):
    """The number of pixels with the colour of a name's plate around a point of the world."""
    color = window.screen.kind.plate
    return near(window.picture(name)[window.map.around(x, y, 0.9)], color, 3).sum()


def test_robots_have_names_and_headings_that_switches_hide(window):
    at_robot = window.map.around(-3.0, 0.0, 0.15)
    red = lambda: near(window.picture("marks")[at_robot], FIRST_ROBOT, 20).sum()  # noqa: E731
    window.screen.move(window.map.pixel(4.0, -2.5))
    window.waiting(lambda: plate(window, "marks", -3.0, 0.0) > 100, "its name")
    assert red() > 40
    blue_robot = window.picture("marks")[window.map.around(0.0, -1.5, 0.15)]
    assert near(blue_robot, (255, 255, 255), 20).sum() > 40  # its colour is its body's, nearly
    assert plate(window, "marks", *CRATE) < 20  # other models have no name

    window.screen.key("n")  # as on the page
    window.screen.choose("alt+v", "e")  # View > Headings
    window.waiting(lambda: plate(window, "no_marks", -3.0, 0.0) < 50, "no name")
    window.waiting(lambda: red() == 0, "no heading")
    window.screen.key("n")
    window.screen.choose("alt+v", "e")
    window.waiting(lambda: red() > 40, "the heading")
    window.waiting(lambda: plate(window, "marks", -3.0, 0.0) > 100, "its name")


def test_all_scans_are_hidden_by_a_key(window):
    before = scans(window, "scans")[0]
    window.screen.key("l")
    window.waiting(lambda: scans(window, "no_scans")[0] < 0.5 * before, "no scans")
    window.screen.key("l")
    window.waiting(lambda: scans(window, "scans")[0] > 0.9 * before, "the scans")


def test_robots_are_seen_from_afar(window):
    window.screen.move(window.map.pixel(-3.0, 0.0))
    window.screen.xdotool("click", "--repeat", 20, "--delay", 30, 5)
    window.waiting(
        lambda: near(window.picture("far")[window.view], FIRST_ROBOT, 20).sum() > 60,
        "an arrow of a few pixels",
        20,
    )
    window.show_all()


def test_a_name_covers_no_neighbour(window):
    window.screen.move(window.map.pixel(4.0, -2.5))
    window.ros.call("/move_model", name="r2", pose={"x": -3.0, "y": -0.6, "theta": 0.0})
    body, above = window.map.around(-3.0, -0.6, 0.12), window.map.around(-3.0, 0.64, 0.2)

    def is_free():
        pixels = window.picture("neighbours")
        covered, moved = (near(pixels[p], window.screen.kind.plate, 3).sum() for p in (body, above))
        return moved > 100 and not covered

    window.waiting(is_free, "the name above, since a robot is below", 20)
    window.ros.call("/move_model", name="r2", pose={"x": 0.0, "y": -1.5, "theta": 1.57})


def test_an_arrow_is_small_on_a_large_robot(window):
    u, v = window.map.pixel(-3.0, 0.0)
    window.screen.move((u, v))
    window.screen.xdotool("click", "--repeat", 20, "--delay", 30, 4)
    _, _, right, bottom = window.screen.inside(window.id)
    window.screen.move((right - 20, bottom - 20))  # else a tooltip covers the robot after a while
    reach = window.screen.px(30)

    def arrow():
        """Its rows and columns, once the robot's body fills the square around it."""
        part = window.picture("arrow")[v - reach : v + reach, u - reach : u + reach]
        corners = np.concatenate([part[:5, :5], part[-5:, :5], part[:5, -5:], part[-5:, -5:]])
        is_arrow = near(part, FIRST_ROBOT, 25)
        return is_arrow.nonzero() if near(corners, (51, 128, 204), 25).all() else None

    ys, xs = window.waiting(arrow, "the arrow", 20)
    assert max(np.ptp(xs), np.ptp(ys)) <= window.screen.px(28)
    window.show_all()


def test_a_door_is_no_robot(window):
    def plates():
        """The number of pixels of plates with names, which robots have, in the view."""
        return near(window.picture("door")[window.view], window.screen.kind.plate, 3).sum()

    before = window.screen.settled(plates, 0.5)
    window.ros.spawn(DOOR, "door", 3.0, 0.0)
    around = window.map.around(3.0, 0.0, 1.0)
    panel = lambda: near(window.picture("door")[around], (64, 140, 153), 25).sum()  # noqa: E731
    window.waiting(lambda: panel() > 100, "the door")
    window.screen.settled(panel, 0.5)
    assert plates() < before + 50
    window.ros.call("/delete_model", name="door")


def test_a_distance_is_measured_on_the_floor(window):
    around = window.map.around(2.5, -1.5, 1.2)
    line = lambda: near(window.picture("measure")[around], (0, 114, 178), 15).sum()  # noqa: E731
    before = line()
    window.screen.focus(window.id)
    window.screen.move(window.map.pixel(2.0, -2.0))
    window.screen.key("m")
    window.drag(window.map.pixel(2.0, -2.0), window.map.pixel(3.0, -1.0))
    window.waiting(lambda: line() > before + 150, "the line and its length")
    window.screen.key("Escape")
    window.waiting(lambda: line() <= before, "their end")


def test_the_model_under_the_mouse_has_a_ring(window):
    color = window.screen.kind.mixed((84, 110, 140), 0.5)
    ring = lambda name: near(  # noqa: E731
        window.picture(name)[window.map.around(*CRATE, 0.6)], color, 20
    ).sum()

    window.screen.move(window.map.pixel(4.0, -2.5))
    before = ring("away")
    window.screen.move(window.map.pixel(*CRATE))
    window.waiting(lambda: ring("hover") > before + 60, "the ring")
    window.screen.move(window.map.pixel(4.0, -2.5))
    window.waiting(lambda: ring("away") < before + 20, "its end")


def test_a_click_selects_and_the_panel_reads_topics(window):
    window.click(0.0, -1.5)
    window.waiting(lambda: "/r2/odometry/filtered" in window.subscriptions(), "the panel")
    assert "/r10/odometry/filtered" not in window.subscriptions()
    window.picture("selected")
    window.click(4.0, 0.5)
    window.waiting(lambda: "/r2/odometry/filtered" not in window.subscriptions(), "no model")


def is_at(window, model, x, y, yaw=None):
    pose = window.ros.pose(model)
    return math.dist(pose[:2], (x, y)) < 0.06 and (yaw is None or abs(pose[2] - yaw) < 0.1)


def test_a_drag_is_undone(window):
    window.drag(window.map.pixel(*CRATE), window.map.pixel(2.5, 0.5))
    window.waiting(lambda: is_at(window, "crate", 2.5, 0.5), "the drag")
    window.screen.key("ctrl+z")
    window.waiting(lambda: is_at(window, "crate", *CRATE), "the undo")


def test_a_model_with_its_origin_aside_follows_the_mouse(window, office):
    """The car's origin is at its rear axle."""
    window.ros.spawn(office.parent / "racetrack/racecar.model.yaml", "car", 3.0, -1.5)
    window.waiting(lambda: is_at(window, "car", 3.0, -1.5), "the car")
    window.drag(window.map.pixel(3.2, -1.5), window.map.pixel(2.4, -0.5))
    window.waiting(lambda: is_at(window, "car", 2.2, -0.5), "the drag")
    window.ros.call("/delete_model", name="car")


def test_a_model_is_deleted_by_its_menu_and_comes_back(window):
    window.open_menu(*CRATE)
    window.screen.key("e")
    window.waiting(lambda: "crate" not in window.ros.models(), "the deletion")
    window.screen.key("ctrl+z")
    window.waiting(lambda: "crate" in window.ros.models(), "the undo")
    window.waiting(lambda: is_at(window, "crate", *CRATE), "it to be where it was")


def test_a_duplicate_has_a_name_and_a_namespace_of_its_own(window):
    window.click(0.0, -1.5)
    window.waiting(lambda: "/r2/scan" in window.subscriptions(), "the selection")
    window.screen.key("ctrl+d")
    window.waiting(lambda: "r3" in window.ros.models(), "the duplicate")
    window.waiting(lambda: "/r3/scan" in window.subscriptions(), "its selection")
    window.screen.key("Delete")
    window.waiting(lambda: "r3" not in window.ros.models(), "the deletion")


def test_a_model_is_moved_by_numbers(window):
    window.click(*CRATE)
    window.screen.key("ctrl+m")
    window.screen.wait_for_window("Move crate")
    window.picture("move_to")
    window.screen.type(f"-1.5, {CRATE[1]}, 0")
    window.screen.key("Return")
    window.waiting(lambda: is_at(window, "crate", -1.5, CRATE[1]), "the move")
    window.screen.key("ctrl+z")
    window.waiting(lambda: is_at(window, "crate", *CRATE), "the undo")


def test_the_view_follows(window):
    middle = window.map.pixel(0.0, 0.0)
    window.click(*CRATE)
    window.screen.key("f")
    follows = lambda: math.dist(window.place_of_crate("follow"), middle) < 6  # noqa: E731
    window.waiting(follows, "the crate in the middle")
    window.ros.call("/move_model", name="crate", pose={"x": -2.0, "y": -2.0, "theta": 0.0})
    window.waiting(lambda: is_at(window, "crate", -2.0, -2.0), "the move")
    window.waiting(follows, "the view to follow")
    # The view rests during a drag: otherwise the crate would move on with it.
    by = np.multiply(window.map.scale, (1.5, -1.0))
    window.drag(middle, np.add(middle, by))
    window.waiting(lambda: is_at(window, "crate", -0.5, -1.0), "the crate where it was dragged")
    window.screen.key("f")
    window.show_all()
    put_back(window)


def test_home_shows_a_model_outside_the_walls(window):
    window.ros.call("/move_model", name="crate", pose={"x": 9.0, "y": 0.0, "theta": 0.0})
    window.waiting(lambda: window.place_of_crate("gone") is None, "the crate to leave the view")

    def is_seen():
        window.screen.key("Home")
        return window.place_of_crate("outside")

    window.waiting(is_seen, "the crate")
    put_back(window)
    window.waiting(lambda: is_at(window, "crate", *CRATE), "the crate within the walls")
    window.show_all()


def test_a_localiser_places_the_robot_as_it_believes(window):
    window.waiting(lambda: scans(window, "placed")[1] == 0, "scans on the walls")
    localiser = window.ros.start("/usr/bin/python3", "-c", LOCALISER)
    window.waiting(lambda: scans(window, "believed")[1] > 50, "a scan beside the walls", 20)
    window.ros.end(localiser)
