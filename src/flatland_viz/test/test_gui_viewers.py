"""Mouse and keyboard in the window and in plain rviz: models are spawned, dragged, turned and
deleted, and the simulation is paused and slowed down. The server's topics have the results.
"""

import math
import time

import numpy as np
import pytest
import yaml
from screen_pictures import near

pytestmark = pytest.mark.slow

BACKGROUND = (238, 238, 236)
WALLS, ROBOT, BOX, SCAN = (102, 102, 102), (51, 128, 204), (194, 145, 87), (204, 0, 0)
TOLERANCE = 40  # of a colour's channels
TOOLBAR = slice(0, 110)  # rows of the screen with menus and tools
ZOOM_CLICKS = 10
ZOOM = 1.12  # of rviz, per click of the wheel


def with_handles(office, frame_rate):
    """The configuration flatland.rviz, with interactive markers and another frame rate [Hz]."""
    file = office.parents[2] / "flatland_viz" / "rviz" / "flatland.rviz"
    config = yaml.safe_load(file.read_text())
    config["Visualization Manager"]["Global Options"]["Frame Rate"] = frame_rate
    displays = config["Visualization Manager"]["Displays"]
    if not any(display["Class"] == "rviz/InteractiveMarkers" for display in displays):
        displays.append(
            {
                "Class": "rviz/InteractiveMarkers",
                "Name": "drag and turn",
                "Enabled": True,
                "Value": True,
                "Update Topic": "/interactive_model_markers/update",
            }
        )
    return config


def straight(begin, end):
    return np.linspace(begin, end, 10)


class View:
    """The mapping from the world to the pixels of a screenshot, seen from above.

    The area with rviz's background colour gives the panel, hence the scale roughly. It is then
    fitted to the pixels of the models in the world's file.
    """

    def __init__(self, pixels, center, scale, models):
        ys, xs = np.nonzero(near(pixels, BACKGROUND, 0))
        self.rows = slice(ys.min(), ys.max() + 1)
        self.columns = slice(xs.min(), xs.max() + 1)
        if callable(scale):
            scale = scale(xs.max() + 1 - xs.min(), ys.max() + 1 - ys.min())
        self.scale = scale
        self._u = (xs.min() + xs.max() + 1) / 2 - scale * center[0]
        self._v = (ys.min() + ys.max() + 1) / 2 + scale * center[1]
        self._measure(pixels, models)

    def _measure(self, pixels, models):
        found = []  # of each model x, y in the world and u, v in the picture
        for (x, y), color in models:
            u, v = self.pixel(x, y)
            reach = 0.5 * self.scale
            ys, xs = np.nonzero(near(pixels, color, TOLERANCE))
            close = np.hypot(xs - u, ys - v) < reach
            if close.sum() > 20 and self.columns.start + reach < u < self.columns.stop - reach:
                found.append((x, y, xs[close].mean() + 0.5, ys[close].mean() + 0.5))
        assert len(found) >= 2, "the models are not where the view should show them"
        x, y, u, v = np.array(found).T
        ones, zeros = np.ones_like(x), np.zeros_like(x)
        rows = np.vstack([np.column_stack([x, ones, zeros]), np.column_stack([-y, zeros, ones])])
        (self.scale, self._u, self._v), *_ = np.linalg.lstsq(
            rows, np.concatenate([u, v]), rcond=None
        )
        errors = [math.dist(self.exact(x, y), (u, v)) for x, y, u, v in found]
        assert max(errors) < 2, f"models are {errors} pixels away from where they belong"

    def exact(self, x, y):
        """The position in the screenshot of a point in the world [m]."""
        return self._u + self.scale * x, self._v - self.scale * y

    def pixel(self, x, y):
        return tuple(round(value) for value in self.exact(x, y))

    def world(self, pixel):
        """The point in the world [m] of a pixel's corner, where the mouse points."""
        return (pixel[0] - self._u) / self.scale, (self._v - pixel[1]) / self.scale


class Viewer:
    """The window or plain rviz, with the office."""

    def __init__(self, kind, screen, ros, office, waiting, folder):
        self.kind, self.screen, self.ros = kind, screen, ros
        self.waiting, self.office = waiting, office
        self.box = str(office / "box.model.yaml")
        world = str(office / "world.yaml")
        if kind == "rviz":
            self._programs = [ros.launch_server(world, "use_rviz:=true")]
            config = folder / "flatland.rviz"
            config.write_text(yaml.safe_dump(with_handles(office, ros.frame_rate)))
            self._programs.append(ros.start("rviz", "-d", config))
            title = ".*flatland.rviz.* - RViz"
        else:
            self._programs = [ros.launch_server(world, "show_viz:=true")]
            title = "Flatland - .*"
        self.window = screen.wait_for_window(title)
        self.models = [
            (model["pose"][:2], BOX)
            for model in yaml.safe_load((office / "world.yaml").read_text())["models"][1:]
        ]
        if kind == "rviz":  # in the window, an arrow is on it
            self.models.append(((0, 0), ROBOT))
        self.view = self._look_closer()
        self.move_beside()
        self._no_handle = self.hint(2.0)

    def close(self):
        for program in reversed(self._programs):
            self.ros.end(program)

    def picture(self, name):
        return self.screen.picture(f"{self.kind}_{name}")

    def hint(self, seconds):
        """The line with rviz's hint for the mouse, once it has been the same for some time [s]."""
        shell = self.screen.xdotool("getwindowgeometry", "--shell", self.window)
        place = {key: int(value) for key, value in (word.split("=") for word in shell)}
        bottom, left = place["Y"] + place["HEIGHT"], place["X"] + 75
        line = slice(bottom - 28, bottom - 6), slice(left, left + 500)
        return self.screen.settled(lambda: self.picture("hint")[line], seconds)

    def move_beside(self):
        """Moves the mouse into an empty corner of the view."""
        self.screen.focus(self.window)
        self.screen.move((self.view.columns.stop - 12, self.view.rows.stop - 12))

    def take_hold(self, pixel):
        """Moves the mouse onto a handle, and waits until rviz shows its hint.

        A hint stays until the next frame; so that of the handle before must be gone first. A
        message takes its place for some seconds, until the mouse moves after that.
        """
        frames = 2.5 / self.ros.frame_rate

        def is_beside():
            self.move_beside()
            return np.array_equal(self.hint(frames), self._no_handle)

        self.waiting(is_beside, "no hint of a handle", 20)

        def is_found():
            self.screen.move(pixel)
            return not np.array_equal(self.hint(frames), self._no_handle)

        self.waiting(is_found, "the handle under the mouse", 20)

    def drag(self, pixels, while_held=lambda: None):
        """A handle, along some pixels."""
        self.take_hold(pixels[0])
        self.screen.drag(pixels, while_held)

    def shows_office(self):
        """Whether everything is shown, by a minimum number of pixels of each colour."""
        pixels = self.picture("office")
        inside = pixels[near(pixels, BACKGROUND, 0).any(axis=1)]
        least = {WALLS: 3000, BOX: 100, SCAN: 200}
        if self.kind == "rviz":
            least[ROBOT] = 6
        return all(near(inside, color, TOLERANCE).sum() >= count for color, count in least.items())

    def _look_closer(self):
        """Zoom in around the middle, by the wheel."""
        self.waiting(self.shows_office, "walls, robot, boxes and scan")
        time.sleep(1)  # the window gets its final size
        pixels = self.picture("office")
        center, scale = (2.5, 0.0), 17.0  # of flatland.rviz
        if self.kind == "window":  # frames the office, 65 m x 25 m
            scale = lambda width, height: 0.92 * min(width / 65, height / 25)  # noqa: E731
        far = View(pixels, center, scale, self.models)
        middle = (far.columns.start + far.columns.stop) // 2, (far.rows.start + far.rows.stop) // 2
        self.screen.move(middle)
        self.screen.xdotool("click", "--repeat", ZOOM_CLICKS, "--delay", 30, 4)
        scale = far.scale * ZOOM**ZOOM_CLICKS

        def near_view():
            try:
                view = View(self.picture("near"), center, scale, self.models)
            except AssertionError:
                return None
            return (
                view if abs(view.scale / scale - 1.0) < 0.03 else None
            )  # it has zoomed all the way

        return self.waiting(near_view, "the view to zoom", limit=20)

    def shows_box(self, name, x, y):
        """Whether more than half of a box's face is visible at a point in the world [m]."""
        u, v = self.view.pixel(x, y)
        reach = int(0.2 * self.view.scale)
        face = self.picture(name)[v - reach : v + reach, u - reach : u + reach]
        return near(face, BOX, TOLERANCE).mean() > 0.5

    def shows_handle(self, name, x, y):
        """Whether a box at a point in the world [m] can be dragged.

        rviz shows its ring. In the window it can be as soon as it is seen.
        """
        if self.kind == "window":
            return self.shows_box(name, x, y)
        pixels = self.picture(name)
        angles = np.radians(np.arange(0, 360, 30))
        places = zip(x + 0.52 * np.cos(angles), y + 0.52 * np.sin(angles))
        colors = np.array([pixels[self.view.pixel(*place)[::-1]] for place in places]).astype(int)
        return (colors[:, 2] - colors[:, 0] > 30).mean() > 0.8  # bluish

    def press(self, key):
        """A key, with the mouse in an empty corner of the view."""
        self.move_beside()
        self.screen.key(key)

    def open_spawn_dialog(self, file=None):
        """The dialog, with the text in its field for the file."""
        self.press("a")
        self.screen.wait_for_window("Spawn Model")
        if file is not None:
            self.screen.key("alt+f", "ctrl+a")
            self.screen.type(file)

    def start_placing(self, file):
        self.open_spawn_dialog(file)
        self.screen.key("Return")
        self.screen.wait_until_closed("Spawn Model")

    def wait_until_paused(self, is_paused):
        self.waiting(
            lambda: self.ros.state()["paused"] == is_paused, f"paused: {is_paused}", limit=15
        )


@pytest.fixture(scope="module", params=["window", "rviz"])
def viewer(request, screen, ros, office, waiting, tmp_path_factory):
    folder = tmp_path_factory.mktemp("rviz")
    viewer = Viewer(request.param, screen, ros, office, waiting, folder)
    yield viewer
    viewer.close()


@pytest.fixture
def crate(viewer):
    """The name of a box in free space, which is deleted afterwards."""
    viewer.ros.spawn(viewer.box, "crate", 2.0, 3.0)
    try:
        viewer.waiting(lambda: viewer.shows_handle("crate", 2.0, 3.0), "the crate's handle", 20)
        yield "crate"
    finally:
        viewer.ros.call("/delete_model", name="crate")  # if it is still there
        viewer.ros.call("/resume")


def test_the_office_is_shown(viewer):
    viewer.waiting(viewer.shows_office, "walls, robot, boxes and scan", 20)
    assert viewer.view.scale > 40  # pixels per metre: it has zoomed


def test_the_office_is_shown_again_after_a_reset(viewer):
    walls = lambda pixels: near(pixels, WALLS, TOLERANCE).sum()  # noqa: E731
    before = walls(viewer.picture("before_reset"))
    answer = viewer.ros.call("/reset", keep_time=False)
    assert answer["success"], answer["message"]
    if viewer.kind == "rviz":  # which discards everything
        viewer.waiting(lambda: walls(viewer.picture("reset")) < 0.5 * before, "the walls to go", 20)
    else:  # the window keeps the walls, and subscribes anew to what moves
        while viewer.ros.clock() < 4.0:
            assert walls(viewer.picture("reset")) > 0.8 * before
    viewer.waiting(viewer.shows_office, "walls, robot, boxes and scan", 20)


def test_a_model_is_spawned_at_a_click_and_faces_the_next(viewer):
    before = set(viewer.ros.models())
    at, towards = viewer.view.pixel(2.0, 3.0), viewer.view.pixel(4.0, 4.0)

    viewer.start_placing(viewer.box)
    viewer.screen.click(at)
    viewer.screen.move(towards)
    viewer.picture("spawning")
    assert set(viewer.ros.models()) == before  # not before the second click
    viewer.screen.click(towards)

    viewer.waiting(lambda: "box" in viewer.ros.models(), "the model to be spawned", limit=20)
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
        viewer.waiting(lambda x=x, y=y: viewer.shows_box("preview", x, y), "the preview", 20)
    assert not viewer.shows_box("preview", -1.5, 4.0)
    viewer.screen.key("Escape")
    viewer.waiting(lambda: not viewer.shows_box("no_preview", -0.5, 3.8), "its end", 20)


@pytest.mark.parametrize(("how", "clicks"), [("Escape", 1), ("right click", 0)])
def test_a_cancelled_spawn_leaves_nothing(viewer, how, clicks):
    before = viewer.ros.models()
    viewer.start_placing(viewer.box)
    for _ in range(clicks):
        viewer.screen.click(viewer.view.pixel(2.0, 3.0))
    if how == "Escape":
        viewer.screen.key("Escape")
    else:
        viewer.screen.click(viewer.view.pixel(3.0, 3.0), button=3)
    for x in (3.5, 4.0):  # would have continued it
        viewer.screen.click(viewer.view.pixel(x, 3.0))
    time.sleep(0.5)
    assert viewer.ros.models() == before
    assert not viewer.screen.windows("Spawn Model")


def test_an_invalid_file_is_reported_and_the_input_kept(viewer):
    before = viewer.ros.models()
    viewer.open_spawn_dialog("/nowhere/at_all.model.yaml")
    without = viewer.picture("wrong_file")
    viewer.screen.key("Return")

    def red(pixels):
        others = pixels[..., 1:].max(axis=2)
        return (pixels[..., 0] > others.astype(np.int16) + 60).sum()

    viewer.waiting(
        lambda: red(viewer.picture("wrong_file")) > red(without) + 50, "the message", limit=20
    )
    assert viewer.screen.windows("Spawn Model")

    # The file is corrected in the same dialog.
    viewer.screen.focus(viewer.screen.windows("Spawn Model")[-1])
    viewer.screen.key("alt+f", "ctrl+a")
    viewer.screen.type(viewer.box)
    viewer.screen.key("Return")
    viewer.screen.wait_until_closed("Spawn Model")
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
    along = [  # in the middle of the ring, which is from 0.44 m to 0.57 m wide
        viewer.view.pixel(2.0 + 0.5 * math.cos(angle), 3.0 + 0.5 * math.sin(angle))
        for angle in np.linspace(0.0, math.pi / 2, 10)
    ]
    if viewer.kind == "window":  # only what is selected or under the mouse has a ring
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
    viewer.waiting(
        lambda: math.dist(viewer.ros.pose(crate)[:2], (1.0, 2.0)) < 0.1, "the drag", limit=15
    )
    time.sleep(0.5)
    assert viewer.ros.state()["paused"]
    viewer.ros.call("/resume")
    viewer.wait_until_paused(False)


def test_a_model_is_deleted_by_its_menu(viewer, crate):
    at = viewer.view.pixel(2.0, 3.0)
    viewer.take_hold(at)
    viewer.screen.click(at, button=3)
    time.sleep(0.5)
    viewer.picture("menu")
    if viewer.kind == "window":
        viewer.screen.key("e")  # D&elete
    else:
        viewer.screen.click((at[0] + 25, at[1] + 12))
    viewer.waiting(lambda: crate not in viewer.ros.models(), "the crate to be deleted", limit=15)
    topic = f"/flatland_server/debug/model/{crate}"
    assert viewer.ros.message(topic, "visualization_msgs/MarkerArray", timeout=0.5) is None


def test_space_and_a_click_pause_and_resume(viewer):
    running = viewer.picture("running")[TOOLBAR]
    viewer.press("space")
    viewer.wait_until_paused(True)
    time.sleep(0.5)
    paused = viewer.picture("paused")[TOOLBAR]
    viewer.press("space")
    viewer.wait_until_paused(False)

    # The button is where the toolbar has changed.
    ys, xs = np.nonzero((running != paused).any(axis=2))
    button = (xs.min() + 8, ys.mean())
    for is_paused in (True, False):
        viewer.screen.click(button)
        viewer.wait_until_paused(is_paused)


def test_the_rate_is_set_by_key_and_dialog(viewer):
    for rate in ("0.5", "1"):
        viewer.press("r")
        viewer.screen.wait_for_window("Change Rate")
        viewer.picture("rate")
        viewer.screen.key("ctrl+a")
        viewer.screen.type(rate)
        viewer.screen.key("Return")
        viewer.waiting(
            lambda rate=rate: viewer.ros.state()["rate"] == float(rate), "the rate", limit=15
        )
        viewer.screen.wait_until_closed("Change Rate")
