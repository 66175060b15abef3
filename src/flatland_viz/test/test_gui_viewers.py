"""Mouse and keyboard in the window and in plain rviz: models are spawned, dragged, turned and
deleted, and the simulation is paused. The server's topics have the results.
"""

import math
import time

import numpy as np
import pytest
import yaml
from office_viewer import BOX, TOLERANCE, Viewer
from screen_pictures import near

pytestmark = pytest.mark.slow

MARKERS_BACKGROUND = (10, 20, 60)
MARKERS = {  # of the world's files, and the least number of pixels
    "layer/map": ((102, 102, 102), 2000),
    "model/turtlebot": ((51, 128, 204), 20),
    "model/box_1": ((194, 145, 87), 60),
}


def markers_only(frame_rate, size):
    """A configuration of rviz's with a display for each topic of markers.

    Args:
        frame_rate: [Hz].
        size: the screen's size [Qt's pixels].
    """
    displays = [
        {
            "Class": "rviz/MarkerArray",
            "Name": topic,
            "Enabled": True,
            "Value": True,
            "Marker Topic": f"/flatland_server/debug/{topic}",
        }
        for topic in MARKERS
    ]
    width, height = size
    return {
        "Visualization Manager": {
            "Global Options": {
                "Fixed Frame": "map",
                "Frame Rate": frame_rate,
                "Background Color": "; ".join(map(str, MARKERS_BACKGROUND)),
            },
            "Displays": displays,
            "Tools": [{"Class": "rviz/Interact"}],
            "Views": {
                "Current": {"Class": "rviz/TopDownOrtho", "X": 2.5, "Y": 0, "Scale": 20, "Angle": 0}
            },
        },
        "Window Geometry": {"Width": width - 20, "Height": height - 60, "X": 5, "Y": 25},
    }


def straight(begin, end):
    return np.linspace(begin, end, 10)


@pytest.fixture(scope="module")
def viewer(viewer_and_screen, screen, ros, office, waiting, run_for_module, tmp_path_factory):
    kind, _ = viewer_and_screen
    folder = tmp_path_factory.mktemp("rviz")
    return Viewer(kind, screen, ros, office, waiting, run_for_module, folder)


@pytest.fixture
def crate(viewer):
    """The name of a box in free space, which is deleted afterwards."""
    viewer.ros.spawn(viewer.box, "crate", 2.0, 3.0)
    try:
        viewer.waiting(lambda: viewer.shows_handle("crate", 2.0, 3.0), "the crate's handle")
        yield "crate"
    finally:
        viewer.ros.call("/delete_model", name="crate")  # if it is still there
        viewer.ros.call("/resume")


def test_the_office_is_shown(viewer):
    viewer.waiting(viewer.shows_office, "walls, robot, boxes and scan")
    assert viewer.view.scale > 40  # pixels per metre: it has zoomed
    if viewer.kind == "window":  # walls are filled where the map is occupied: a pillar
        (left, top), (right, bottom) = viewer.view.pixel(-0.3, 2.75), viewer.view.pixel(0.3, 2.15)
        pillar = viewer.picture("office")[top:bottom, left:right]
        assert near(pillar, viewer.walls, TOLERANCE).mean() > 0.8


def test_the_office_is_shown_again_after_a_reset(viewer):
    walls = lambda pixels: near(pixels, viewer.walls, TOLERANCE).sum()  # noqa: E731
    boxes = lambda pixels: near(pixels, BOX, TOLERANCE).sum()  # noqa: E731
    pixels = viewer.picture("before_reset")
    before, boxes_before = walls(pixels), boxes(pixels)
    answer = viewer.ros.call("/reset", restart_time=True)
    assert answer["success"], answer["message"]
    if viewer.kind == "rviz":  # which discards everything
        viewer.waiting(lambda: walls(viewer.picture("reset")) < 0.5 * before, "the walls to go")
    else:  # the window keeps what it shows until the new run is there
        while viewer.ros.clock() < 4.0:
            pixels = viewer.picture("reset")
            assert walls(pixels) > 0.8 * before
            assert boxes(pixels) > 0.8 * boxes_before
            time.sleep(0.05)  # a frame lasts four times as long
    viewer.waiting(viewer.shows_office, "walls, robot, boxes and scan")


def test_a_model_is_spawned_at_the_press_and_faces_the_release(viewer):
    before = set(viewer.ros.models())
    at, towards = viewer.view.pixel(2.0, 3.0), viewer.view.pixel(4.0, 4.0)

    viewer.start_placing(viewer.box)

    def while_held():
        viewer.picture("spawning")
        assert set(viewer.ros.models()) == before  # not before the release

    viewer.screen.drag(straight(at, towards), while_held)

    viewer.waiting(lambda: "box" in viewer.ros.models(), "the model to be spawned")
    x, y, yaw = viewer.ros.pose("box")
    viewer.picture("spawned")
    viewer.ros.call("/delete_model", name="box")
    expected = viewer.view.world(at)
    turn = math.atan2(at[1] - towards[1], towards[0] - at[0])
    assert (x, y) == pytest.approx(expected, abs=0.05)
    assert yaw == pytest.approx(turn, abs=math.radians(3))


def test_a_preview_follows_the_mouse(viewer):
    viewer.start_placing(viewer.box)
    for x, y in ((-1.5, 4.0), (-0.5, 3.8)):
        viewer.screen.move(viewer.view.pixel(x, y))
        viewer.waiting(lambda x=x, y=y: viewer.shows_box("preview", x, y), "the preview")
    assert not viewer.shows_box("preview", -1.5, 4.0)
    viewer.screen.key("Escape")
    viewer.waiting(lambda: not viewer.shows_box("no_preview", -0.5, 3.8), "its end")


@pytest.mark.parametrize("how", ["Escape", "right click"])
def test_a_cancelled_spawn_leaves_nothing(viewer, how):
    before = viewer.ros.models()
    viewer.start_placing(viewer.box)
    if how == "Escape":
        at, towards = viewer.view.pixel(2.0, 3.0), viewer.view.pixel(3.0, 3.0)
        viewer.screen.drag(straight(at, towards), lambda: viewer.screen.key("Escape"))
    else:
        viewer.screen.click(viewer.view.pixel(3.0, 3.0), button=3)
    for x in (3.5, 4.0):  # clicks that would have continued the spawn
        viewer.screen.click(viewer.view.pixel(x, 3.0))
    time.sleep(0.5)
    assert viewer.ros.models() == before
    assert not viewer.screen.windows("Spawn Model")


def test_an_invalid_file_is_reported_and_the_input_kept(viewer):
    before = viewer.ros.models()
    dialog = viewer.open_spawn_dialog("/nowhere/at_all.model.yaml")

    def red():
        pixels = viewer.screen.picture_of(dialog, f"{viewer.kind}_wrong_file")
        others = pixels[..., 1:].max(axis=2)
        return (pixels[..., 0] > others.astype(np.int16) + 60).sum()

    without = red()
    viewer.screen.key("Return")
    viewer.waiting(lambda: red() > without + 50, "the message")
    assert viewer.screen.windows("Spawn Model")
    assert viewer.screen.has(dialog)

    # The file is corrected in the same dialog.
    viewer.screen.focus(viewer.screen.windows("Spawn Model")[-1])
    viewer.screen.type(viewer.box)  # the wrong one is selected
    viewer.screen.close("Spawn Model", "Return")
    viewer.screen.key("Escape")
    assert viewer.ros.models() == before


def test_a_model_is_dragged_while_the_simulation_waits(viewer, crate):
    begin, end = viewer.view.pixel(2.0, 3.0), viewer.view.pixel(0.5, 1.5)

    def while_held():
        viewer.picture("dragging")
        viewer.wait_until_paused(True)
        clock = viewer.ros.state()["stamp"]
        time.sleep(3.5)  # longer than the server waits for feedback
        viewer.picture("dragging")
        assert viewer.ros.state()["paused"]
        assert viewer.ros.state()["stamp"] == clock
        assert math.dist(viewer.ros.pose(crate)[:2], (0.5, 1.5)) < 0.1

    viewer.drag(straight(begin, end), while_held)
    viewer.wait_until_paused(False)
    x, y, yaw = viewer.ros.pose(crate)
    by = np.subtract(viewer.view.world(end), viewer.view.world(begin))
    assert (x, y) == pytest.approx((2.0 + by[0], 3.0 + by[1]), abs=0.05)
    assert yaw == pytest.approx(0.0, abs=math.radians(1))


def test_a_model_is_turned_by_its_ring(viewer, crate):
    ring = viewer.ring_radius()
    along = [
        viewer.view.pixel(2.0 + ring * math.cos(angle), 3.0 + ring * math.sin(angle))
        for angle in np.linspace(0.0, math.pi / 2, 10)
    ]
    if viewer.kind == "window":  # a ring only around the selected model and the one under the mouse
        viewer.take_hold(viewer.view.pixel(2.0, 3.0))  # a click chooses what rviz has found there
        viewer.screen.click(viewer.view.pixel(2.0, 3.0))
    viewer.screen.move(along[0])
    viewer.picture("ring")
    viewer.drag(along, lambda: viewer.wait_until_paused(True))
    viewer.wait_until_paused(False)
    x, y, yaw = viewer.ros.pose(crate)
    assert (x, y) == pytest.approx((2.0, 3.0), abs=0.05)
    assert yaw == pytest.approx(math.pi / 2, abs=math.radians(5))


def test_a_drag_in_a_pause_does_not_end_it(viewer, crate):
    viewer.ros.call("/pause")
    viewer.wait_until_paused(True)
    viewer.drag(straight(viewer.view.pixel(2.0, 3.0), viewer.view.pixel(1.0, 2.0)))
    viewer.waiting(lambda: math.dist(viewer.ros.pose(crate)[:2], (1.0, 2.0)) < 0.1, "the drag")
    time.sleep(0.5)
    assert viewer.ros.state()["paused"]
    viewer.ros.call("/resume")
    viewer.wait_until_paused(False)


def test_a_model_is_deleted_by_its_menu(viewer, crate):
    at = viewer.view.pixel(2.0, 3.0)
    viewer.take_hold(at)
    viewer.screen.open_menu(at, f"{viewer.kind}_menu")
    if viewer.kind == "window":
        viewer.screen.key("e")  # D&elete
    else:
        viewer.screen.click((at[0] + viewer.screen.px(25), at[1] + viewer.screen.px(12)))
    viewer.waiting(lambda: crate not in viewer.ros.models(), "the crate to be deleted")
    topic = f"/flatland_server/debug/model/{crate}"
    assert viewer.ros.message(topic, "visualization_msgs/MarkerArray", timeout=0.5) is None


def test_space_and_a_click_pause_and_resume(viewer):
    toolbar = slice(0, viewer.view.rows.start)  # rows above the view
    running = viewer.picture("running")[toolbar]
    viewer.press("space")
    viewer.wait_until_paused(True)
    time.sleep(0.5)
    paused = viewer.picture("paused")[toolbar]
    viewer.press("space")
    viewer.wait_until_paused(False)

    # The button is where the toolbar has changed.
    ys, xs = np.nonzero((running != paused).any(axis=2))
    button = (xs.min() + viewer.screen.px(8), ys.mean())
    for is_paused in (True, False):
        viewer.screen.click(button)
        viewer.wait_until_paused(is_paused)


def test_markers_alone_show_the_world(viewer, tmp_path):
    """Rviz loads a configuration of a user's, with displays of markers only."""
    if viewer.kind == "window":
        pytest.skip("it loads no configurations")
    file = tmp_path / "generic.rviz"
    file.write_text(yaml.safe_dump(markers_only(viewer.ros.frame_rate, viewer.screen.qt_size)))
    answer = viewer.ros.call("/rviz/load_config_discarding_changes", path={"data": str(file)})
    assert answer["success"]

    def missing():
        pixels = viewer.picture("generic")
        ys, xs = np.nonzero(near(pixels, MARKERS_BACKGROUND, 0))
        if not len(ys):
            return list(MARKERS)
        view = pixels[ys.min() : ys.max(), xs.min() : xs.max()]
        return [
            topic
            for topic, (color, least) in MARKERS.items()
            if near(view, color, 40).sum() < least
        ]

    viewer.waiting(lambda: not missing(), "walls, robot and box")


def test_closing_the_window_not_rviz_ends_the_launch(viewer):
    launch = viewer.launch
    if viewer.kind == "rviz":
        viewer.ros.end(viewer.program)
        assert viewer.program.returncode == 0
        assert launch.process.poll() is None
        launch.press_ctrl_c()
        assert launch.process.wait(60) == 0
        return
    viewer.screen.focus(viewer.window)
    viewer.screen.key("ctrl+q")

    assert launch.process.wait(60) == 0
    assert "REQUIRED process" not in launch.output  # nothing has died
    assert "Traceback" not in launch.output
    assert "escalating" not in launch.output
