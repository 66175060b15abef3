"""The office in the window or in plain rviz, zoomed in on, with mouse and keyboard."""

import math

import numpy as np
import yaml
from gui_screen import FIRST_ROBOT
from plain_rviz import plain_rviz
from screen_pictures import near

WALLS, ROBOT, BOX, SCAN = (102, 102, 102), (51, 128, 204), (194, 145, 87), FIRST_ROBOT
TOLERANCE = 40  # of a colour's channels
LEAST_SCALE = 45  # pixels per metre, when it has zoomed
ZOOM = 1.12  # of rviz, per click of the wheel


def with_handles(office, frame_rate, background, size):
    """The configuration flatland.rviz, with interactive markers.

    Args:
        office: the folder of the world.
        frame_rate: [Hz].
        background: its colour.
        size: of the screen, which rviz's window fills [Qt's pixels].
    """
    file = office.parents[2] / "flatland_viz" / "rviz" / "flatland.rviz"
    config = yaml.safe_load(file.read_text())
    options = config["Visualization Manager"]["Global Options"]
    options.update({"Frame Rate": frame_rate, "Background Color": "; ".join(map(str, background))})
    config["Panels"] = []
    width, height = size
    config["Window Geometry"] = {"Width": width - 20, "Height": height - 60, "X": 5, "Y": 25}
    # Removes rviz's other tools, to make room for ours on a small screen.
    tools = config["Visualization Manager"]["Tools"]
    config["Visualization Manager"]["Tools"] = [
        tool for tool in tools if tool["Class"].startswith(("flatland_viz/", "rviz/Interact"))
    ]
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


class View:
    """The mapping from the world to the pixels of a screenshot, seen from above.

    The place of rviz's view gives the scale roughly. It is then fitted to the pixels of the models
    in the world's file.
    """

    def __init__(self, pixels, rows, columns, center, scale, models):
        self.rows, self.columns = rows, columns
        self.scale = scale
        self._u = (columns.start + columns.stop) / 2 - scale * center[0]
        self._v = (rows.start + rows.stop) / 2 + scale * center[1]
        self._measure(pixels, models)

    def _measure(self, pixels, models):
        found = []  # for each model: x, y in the world and u, v in the picture
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
    """The window or plain rviz, with the office, which scripts/run has launched.

    Args:
        kind: "window" or "rviz".
        screen: the X display that shows it.
        ros: the master that the launch joins.
        office: the folder of the world.
        waiting: `wait_until`.
        run: starts scripts/run.
        folder: for rviz's configuration.
    """

    def __init__(self, kind, screen, ros, office, waiting, run, folder):
        self.kind, self.screen, self.ros = kind, screen, ros
        self.waiting, self.office = waiting, office
        self.background = screen.kind.background
        self.walls = screen.kind.walls if kind == "window" else WALLS
        self.box = str(office / "box.model.yaml")
        self.launch = ros.launch(run, f"use_rviz:={str(kind == 'rviz').lower()}")
        title = "Flatland - .*"
        if kind == "rviz":
            config = folder / "flatland.rviz"
            config.write_text(
                yaml.safe_dump(
                    with_handles(office, ros.frame_rate, self.background, screen.qt_size)
                )
            )
            self.program = ros.start(*plain_rviz(folder), "-d", config, "__name:=rviz")
            title = ".*flatland.rviz.* - RViz"
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

    def picture(self, name):
        return self.screen.picture(f"{self.kind}_{name}")

    def hint(self, seconds):
        """The line with rviz's hint for the mouse, once it has not changed for some time [s]."""
        left, _, _, bottom = self.screen.inside(self.window)
        line = slice(bottom - self.screen.px(26), bottom - self.screen.px(5))
        # In the window, other fields leave little room for it; in rviz, it is beside a button.
        begin, end = (2, 85) if self.kind == "window" else (75, 300)
        part = slice(left + self.screen.px(begin), left + self.screen.px(end))
        return self.screen.settled(lambda: self.picture("hint")[line, part], seconds)

    def move_beside(self):
        """Moves the mouse into an empty corner of the view."""
        self.screen.focus(self.window)
        aside = self.screen.px(12)
        self.screen.move((self.view.columns.stop - aside, self.view.rows.stop - aside))

    def take_hold(self, pixel):
        """Moves the mouse onto a handle, and waits until rviz shows its hint.

        A hint stays until the next frame, so the former handle's hint must be gone first. A message
        replaces the hint for some seconds, and until the mouse moves again.
        """
        frames = 2.5 / self.ros.frame_rate

        def is_beside():
            self.move_beside()
            return np.array_equal(self.hint(frames), self._no_handle)

        self.waiting(is_beside, "no hint of a handle")

        def is_found():
            self.screen.move(pixel)
            return not np.array_equal(self.hint(frames), self._no_handle)

        self.waiting(is_found, "the handle under the mouse")

    def drag(self, pixels, while_held=lambda: None):
        """Drags a handle along some pixels."""
        self.take_hold(pixels[0])
        self.screen.drag(pixels, while_held)

    def shows_office(self):
        """True if everything is shown, by a minimum number of pixels of each colour."""
        pixels = self.picture("office")
        inside = pixels[self.screen.view(pixels)]
        least = {self.walls: 700, BOX: 60, SCAN: 150}
        if self.kind == "rviz":
            least[ROBOT] = 6
        return all(near(inside, color, TOLERANCE).sum() >= count for color, count in least.items())

    def _look_closer(self):
        """Zooms in around the middle, by the wheel."""
        self.waiting(self.shows_office, "walls, robot, boxes and scan")
        # The window gets its final size.
        rows, columns = self.screen.settled(lambda: self.screen.view(self.picture("office")), 1.0)
        pixels = self.picture("office")
        center, scale = (2.5, 0.0), 17.0  # of flatland.rviz
        if self.kind == "window":  # frames the office, 65 m x 25 m
            width, height = columns.stop - columns.start, rows.stop - rows.start
            scale = 0.92 * min(width / 65, height / 25)
        far = View(pixels, rows, columns, center, scale, self.models)
        clicks = math.ceil(math.log(LEAST_SCALE / far.scale) / math.log(ZOOM))
        self.screen.move(((columns.start + columns.stop) // 2, (rows.start + rows.stop) // 2))
        self.screen.xdotool("click", "--repeat", clicks, "--delay", 30, 4)
        scale = far.scale * ZOOM**clicks

        def near_view():
            try:
                view = View(self.picture("near"), rows, columns, center, scale, self.models)
            except AssertionError:
                return None
            # It has zoomed all the way.
            return view if abs(view.scale / scale - 1.0) < 0.03 else None

        return self.waiting(near_view, "the view to zoom")

    def shows_box(self, name, x, y):
        """True if more than half of a box's face is visible at a point in the world [m]."""
        u, v = self.view.pixel(x, y)
        reach = int(0.2 * self.view.scale)
        face = self.picture(name)[v - reach : v + reach, u - reach : u + reach]
        return near(face, BOX, TOLERANCE).mean() > 0.5

    def shows_handle(self, name, x, y):
        """True if a box at a point in the world [m] can be dragged.

        rviz shows its ring. In the window, a visible box can be dragged.
        """
        if self.kind == "window":
            return self.shows_box(name, x, y)
        pixels = self.picture(name)
        angles = np.radians(np.arange(0, 360, 30))
        places = zip(x + 0.52 * np.cos(angles), y + 0.52 * np.sin(angles))
        colors = np.array([pixels[self.view.pixel(*place)[::-1]] for place in places]).astype(int)
        return (colors[:, 2] - colors[:, 0] > 30).mean() > 0.8  # bluish

    def ring_radius(self):
        """The radius of the ring that turns a box [m].

        rviz's is from 0.44 m to 0.57 m wide; the window's has at least 20 of Qt's pixels.
        """
        least = self.screen.px(20) / self.view.scale if self.kind == "window" else 0.0
        return max(0.5, least)

    def press(self, key):
        """Presses a key with the mouse in an empty corner of the view."""
        self.move_beside()
        self.screen.key(key)

    def open_spawn_dialog(self, file=None):
        """Opens the dialog with this file."""
        self.press("a")
        dialog = self.screen.wait_for_dialog("Spawn Model")
        if file is not None:
            self.screen.key("alt+f", "ctrl+a")
            self.screen.type(file)
        return dialog

    def start_placing(self, file):
        self.open_spawn_dialog(file)
        self.screen.close("Spawn Model", "Return")

    def wait_until_paused(self, is_paused):
        self.waiting(lambda: self.ros.state()["paused"] == is_paused, f"paused: {is_paused}")
