"""The window fits on its screen with any content, and remembers its panels and background."""

from pathlib import Path

import pytest
from gui_screen import FIRST_ROBOT
from screen_pictures import near
from screens import ScreenKind

pytestmark = pytest.mark.slow

WORLDS = Path(__file__).resolve().parents[2] / "flatland_server" / "worlds"
WORLD = f"""properties: {{}}
layers:
  - {{name: room, map: {WORLDS}/test_room/room.yaml, color: [0.4, 0.4, 0.4, 1]}}
  - {{name: white, map: white.yaml}}
models:
  - {{name: turtlebot, pose: [0, 0, 0], model: {WORLDS}/office/turtlebot.model.yaml}}
"""
WHITE = "{type: line_segments, data: white.dat, scale: 1, origin: [0, 0, 0]}"
DIMMED = (172, 172, 172)
"""White walls in the dark look."""
AMBER = (240, 196, 25)
TITLE = "Flatland - test_room/world.yaml"
SELECTED = (70, 76, 84)
SMALL = (1024, 660)  # pixels: at double size as few as a phone's


@pytest.fixture(scope="module")
def open_window(ros, screen, tmp_path_factory):
    """Opens the window beside a running server."""
    world = tmp_path_factory.mktemp("worlds") / "test_room" / "world.yaml"
    world.parent.mkdir()
    for name, text in (("white.yaml", WHITE), ("white.dat", "-4 2 -2 2\n"), (world.name, WORLD)):
        (world.parent / name).write_text(text)
    ros.start_server(world)

    def start():
        return ros.start_window(), screen.wait_for_window(TITLE)

    return start


class Looks:
    """Checks of the window's appearance."""

    def __init__(self, screen, background):
        self.screen, self.background = screen, background

    def has_background(self, name):
        """True if the view has the background, and walls that stand out on it."""
        pixels = self.screen.picture(name)
        is_seen = near(pixels, self.background.background, 2)
        ys, xs = is_seen.nonzero()
        if is_seen.mean() <= 0.15:
            return False
        view = pixels[ys.min() : ys.max(), xs.min() : xs.max()]
        dims = not self.background.is_dark or near(view, DIMMED, 4).sum() > 50
        return dims and near(view, self.background.walls, 5).sum() > 300

    def has_problem(self, name):
        """True if the status line has the badge of warnings."""
        return near(self.screen.picture(name), AMBER, 5).sum() > 300

    def panel(self, name):
        """A screenshot of the area to the right of the view, and its left edge."""
        pixels = self.screen.picture(name)
        begin = int(near(pixels, self.background.background, 0).nonzero()[1].max()) + 1
        return pixels[:, begin:], begin

    def row_of_robot(self, name):
        """The middle of the robot's dot in the list of models; None if it is not visible."""
        panel, begin = self.panel(name)
        ys, xs = near(panel, FIRST_ROBOT, 10).nonzero()
        return (begin + xs.mean(), ys.mean()) if len(xs) > 20 else None

    def is_all_alike(self, name):
        """True if the panels are dark with a dark view, and light with a light one."""
        return (self.panel(name)[0].mean() < 100) == self.background.is_dark

    def has_selected_row(self, name):
        return near(self.panel(name)[0], SELECTED, 2).sum() > 1000

    def has_toolbar(self, name, window):
        """True if there is a toolbar between the menus and the view."""
        pixels = self.screen.picture(name)
        rows = near(pixels, self.background.background, 0).sum(axis=1) > 100
        rows = slice(int(rows.argmax()), None)
        return rows.start - self.screen.inside(window)[1] > self.screen.px(45)


def drives(ros):
    """True if the Drive panel is shown: it has opened the topic of the robot."""
    return "/flatland_viz" in dict(ros.master.ask("getSystemState")[0]).get("/cmd_vel", ())


def test_the_window_fits_and_remembers(open_window, ros, screen, waiting):
    program, window = open_window()
    kind = screen.kind
    looks = Looks(screen, kind)
    waiting(lambda: looks.has_background("fits_first"), "the room")
    assert screen.has(window)
    screen.click(waiting(lambda: looks.row_of_robot("fits_list"), "the robot in the list", 20))
    waiting(lambda: looks.has_selected_row("fits_selected"), "a selected model")
    assert screen.has(window)
    screen.key("F4")
    waiting(lambda: drives(ros), "the panel to drive")
    screen.picture("fits_drive")
    assert screen.has(window)
    screen.key("F1")
    keys = screen.wait_for_window("Keys and Mouse")
    assert screen.has(keys)
    screen.picture("fits_keys")
    screen.close("Keys and Mouse")

    # The window can be made smaller.
    screen.focus(window)
    screen.xdotool("windowsize", window, *SMALL)

    def is_small():
        left, top, right, bottom = screen.inside(window)
        return (right - left, bottom - top) == SMALL

    waiting(is_small, "a smaller window")
    screen.picture("fits_small")

    other = ScreenKind(kind.width, kind.height, kind.scale, not kind.is_dark)
    screen.choose("alt+v", "c", "l" if kind.is_dark else "d")
    looks = Looks(screen, other)
    waiting(lambda: looks.has_background("fits_other"), "the other background", 30)
    waiting(lambda: looks.is_all_alike("fits_other"), "panels in the same look")
    screen.key("alt+F4")  # as by the button of its title bar
    screen.wait_until_closed(TITLE)
    assert program.wait(60) == 0

    # The server goes on, and the next window has the last one's panels and background, and what
    # the server has warned of meanwhile.
    assert not looks.has_problem("fits_again")
    ros.call("/delete_model", name="nothing")
    program, window = open_window()
    waiting(lambda: looks.has_problem("fits_again"), "the badge", 30)
    waiting(lambda: looks.has_background("fits_again"), "the same background", 30)
    waiting(lambda: drives(ros), "the panel to drive")
    left, top, right, bottom = screen.inside(window)
    assert (right - left, bottom - top) == SMALL
    assert looks.has_toolbar("fits_again", window)

    screen.key("alt+v", "t")
    waiting(lambda: not looks.has_toolbar("fits_bare", window), "the toolbar to go")
    screen.key("alt+v", "l")
    waiting(lambda: looks.has_toolbar("fits_reset", window), "the toolbar of the first start")
    waiting(lambda: not drives(ros), "the first start's panels")
