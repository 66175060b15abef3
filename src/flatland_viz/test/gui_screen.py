"""A screen with mouse, keyboard and screenshots."""

import os
import re
import subprocess
import sys
import time

import numpy as np
import waiting as waits
from screen_pictures import Screenshots, near

LIMIT = 60.0  # s: generous, for a loaded machine
INTERVAL = 0.2  # s: screenshots take processor time from the programs under test
FIRST_ROBOT = (213, 94, 0)  # colour of the first robot's arrow, ring and scan
OFFICE_COLORS = (  # of the world's files and our rviz configuration; least number of pixels
    # An arrow is on the robot.
    ((194, 145, 87), 60),  # boxes
    (FIRST_ROBOT, 150),  # scan
)
CLIPBOARD = """
import sys
from PyQt5.QtWidgets import QApplication
application = QApplication([])
application.clipboard().setText(sys.argv[1])
application.processEvents()
print(flush=True)
application.exec_()
"""
"""A program that keeps a text in the clipboard while it runs."""
DARK_SETTINGS = "[switches]\naction_background_dark=true\n"


def wait_until(holds, what, limit=LIMIT):
    """The first true value of `holds()`."""
    return waits.wait_until(holds, what, limit, INTERVAL)


class Screen:
    """An X display, controlled by xdotool.

    Args:
        display: name of the X display, such as ":51".
        kind: its size, scale and background.
        name: of the screen, for the files of its pictures.
        settings: folder for the window's settings, among them the background.
    """

    def __init__(self, display, kind, name, settings):
        self.display, self.kind = display, kind
        self.environment = {
            **os.environ,
            "DISPLAY": display,
            "LIBGL_ALWAYS_SOFTWARE": "1",
            "XDG_CONFIG_HOME": str(settings),
            "QT_SCALE_FACTOR": str(kind.scale),
        }
        if kind.is_dark:
            (settings / "flatland").mkdir(parents=True)
            (settings / "flatland" / "window.conf").write_text(DARK_SETTINGS)
        self._clipboard = None
        self._screenshots = Screenshots(display, f"gui_{name}")
        self.picture = self._screenshots.take
        self.save_pictures = self._screenshots.save

    @property
    def qt_size(self):
        """Its width and height [Qt's pixels]."""
        return self.kind.width // self.kind.scale, self.kind.height // self.kind.scale

    def px(self, length):
        """A length in Qt's pixels, in those of the screen."""
        return round(length * self.kind.scale)

    def view(self, pixels):
        """Rows and columns of a screenshot that rviz's view of the world takes, as slices.

        They are found by the background, and empty if it is not visible.
        """
        ys, xs = np.nonzero(near(pixels, self.kind.background, 0))
        if not len(ys):
            return slice(0, 0), slice(0, 0)
        return slice(ys.min(), ys.max() + 1), slice(xs.min(), xs.max() + 1)

    def shows_office(self, name):
        """True if the window shows the office, by a minimum number of pixels of each colour."""
        pixels = self.picture(name)
        colors = ((self.kind.walls, 700), *OFFICE_COLORS)
        return all(near(pixels, color, 30).sum() >= least for color, least in colors)

    def settled(self, look, seconds):
        """The result of `look()`, once it has not changed for some time [s]."""
        values, times = [look()], [time.monotonic()]

        def is_settled():
            value = look()
            if np.array_equal(value, values[-1]):
                return time.monotonic() - times[-1] >= seconds
            values.append(value)
            times.append(time.monotonic())
            return False

        wait_until(is_settled, "what is on the screen to stay the same")
        return values[-1]

    def xdotool(self, *arguments):
        """Runs xdotool for mouse, keyboard or windows. Returns the words of its output."""
        return self._run_xdotool(*arguments).stdout.split()

    def _run_xdotool(self, *arguments):
        return subprocess.run(
            ["xdotool", *map(str, arguments)], env=self.environment, capture_output=True, text=True
        )

    def windows(self, title):
        """The visible windows with this title.

        xdotool asks for each window of the screen in turn, and ends with an X error, finding none,
        if one of them is closed meanwhile: then it has to look again.
        """
        while True:
            search = self._run_xdotool("search", "--onlyvisible", "--name", f"^{title}$")
            if "BadWindow" not in search.stderr:
                return search.stdout.split()

    def wait_for_window(self, title):
        window = wait_until(lambda: self.windows(title), f"the window {title!r}")[-1]
        self.focus(window)
        return window

    def wait_for_dialog(self, title):
        """Waits for a dialog, which must fit on the screen."""
        dialog = self.wait_for_window(title)
        assert self.has(dialog), (title, self.frame(dialog))
        return dialog

    def wait_until_closed(self, title):
        wait_until(lambda: not self.windows(title), f"the window {title!r} to close")

    def close(self, title, key="Escape"):
        """Closes a dialog by a key."""
        self.key(key)
        self.wait_until_closed(title)

    def frame(self, window):
        """Left, top, right and bottom of a window with its title bar [pixels]."""
        return self._area("-frame", "-id", window)

    def inside(self, window):
        """Left, top, right and bottom of a window without its title bar [pixels]."""
        return self._area("-id", window)

    def _area(self, *arguments):
        text = subprocess.run(
            ["xwininfo", "-stats", *arguments],
            env=self.environment,
            stdout=subprocess.PIPE,
            text=True,
        ).stdout
        fields = ("Absolute upper-left X", "Absolute upper-left Y", "Width", "Height")
        x, y, width, height = (int(re.search(rf"{field}: +(-?\d+)", text)[1]) for field in fields)
        return x, y, x + width, y + height

    def has(self, window):
        """True if a window with its title bar is on the screen as a whole."""
        left, top, right, bottom = self.frame(window)
        return left >= 0 and top >= 0 and right <= self.kind.width and bottom <= self.kind.height

    def picture_of(self, window, name):
        """A screenshot of a window and its frame."""
        left, top, right, bottom = self.frame(window)
        return self.picture(name)[max(0, top) : bottom, max(0, left) : right]

    def focus(self, window):
        """Gives a window the keyboard, as a window manager does."""
        self.xdotool("windowfocus", "--sync", window)

    def key(self, *keys):
        self.xdotool("key", "--delay", 40, *keys)

    def choose(self, *keys):
        """Presses the keys of menus within each other, each once the menu before it is open.

        Qt opens a submenu some milliseconds after its key. A key that a busy window takes before
        goes to the menu above, where it may be that of another entry.
        """
        *menus, entry = keys
        for key in menus:
            before = len(self.windows(".*"))
            self.key(key)
            wait_until(lambda: len(self.windows(".*")) > before, f"the menu of {key}")  # noqa: B023
        self.key(entry)

    def type(self, text):
        """Types a text; if not ASCII, by the clipboard: xdotool maps other letters too briefly."""
        if str(text).isascii():
            self.xdotool("type", "--delay", 3, "--", text)
            return
        if self._clipboard:
            self._clipboard.terminate()
            self._clipboard.communicate()
        self._clipboard = subprocess.Popen(  # until the next text, or the end of the display
            [sys.executable, "-c", CLIPBOARD, str(text)],
            env=self.environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )
        self._clipboard.stdout.readline()
        self.key("ctrl+v")

    def click(self, pixel, button=1):
        self.move(pixel)
        self.xdotool("click", button)
        time.sleep(0.2)

    def move(self, pixel):
        """Moves the mouse in two steps: rviz looks for the object under it on each motion."""
        x, y = map(int, pixel)
        self.xdotool("mousemove", x - 2, y, "sleep", 0.1, "mousemove", x, y, "sleep", 0.1)

    def open_menu(self, pixel, name):
        """Right-clicks in the view; returns once a menu covers a part of its background."""
        least = self.px(40) * self.px(60)
        background = lambda: near(self.picture(name), self.kind.background, 0).sum()  # noqa: E731
        before = background()
        self.click(pixel, button=3)
        wait_until(lambda: background() < before - least, "the menu")

    def drag(self, pixels, while_held=lambda: None):
        """Drags with the left button along some pixels."""
        self.move(pixels[0])
        time.sleep(0.3)
        self.xdotool("mousedown", 1)
        for x, y in pixels:
            self.xdotool("mousemove", round(x), round(y), "sleep", 0.05)
        try:
            while_held()
        finally:
            self.xdotool("mouseup", 1)
