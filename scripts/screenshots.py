"""The pictures of docs/images: a simulator and its window under Xvfb, a mouse, and a camera."""

import io
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
from PIL import Image

ROOT = Path(sys.argv[1])
IMAGES = ROOT / "docs" / "images"
BOX = ROOT / "src" / "flatland_server" / "worlds" / "office" / "box.model.yaml"
SIZE = (1296, 868)  # of the screen: the window, and room for a window manager's frame
TOOLBAR = 90  # height [pixels]
TIMELINE = 130  # from the lower edge of the screen [pixels]
PORT = 11399
ROBOT, SCAN = (51, 128, 204), (213, 94, 0)
LIMIT = 60.0  # s
ZOOM_CLICKS = 11


class Screen:
    """An X server with a window that fills it."""

    def __init__(self):
        read, write = os.pipe()
        size = "x".join(map(str, (*SIZE, 24)))
        self._server = subprocess.Popen(
            [
                "Xvfb",
                "-displayfd",
                str(write),
                "-screen",
                "0",
                size,
                "-noreset",
                "-nolisten",
                "tcp",
            ],
            pass_fds=[write],
            stderr=subprocess.DEVNULL,
        )
        os.close(write)
        with os.fdopen(read) as pipe:
            display = f":{pipe.readline().strip()}"
        self.environment = {
            **os.environ,
            "DISPLAY": display,
            "LIBGL_ALWAYS_SOFTWARE": "1",
            "ROS_MASTER_URI": f"http://127.0.0.1:{PORT}",
            "ROS_IP": "127.0.0.1",
        }

    def close(self):
        """Ends it."""
        self._server.terminate()
        self._server.wait()

    def picture(self):
        """A screenshot."""
        raw = subprocess.run(
            ["import", "-window", "root", "png:-"],
            env=self.environment,
            check=True,
            stdout=subprocess.PIPE,
        )
        return Image.open(io.BytesIO(raw.stdout)).convert("RGB")

    def save(self, name):
        """Keeps a picture of the window."""
        path = IMAGES / f"{name}.png"
        command = "xdotool search --onlyvisible --name '^Flatland - ' getwindowgeometry --shell"
        lines = subprocess.check_output(command, shell=True, env=self.environment, text=True)
        place = {key: int(value) for key, value in (line.split("=") for line in lines.split())}
        left, top = place["X"], place["Y"]
        area = (left, top, left + place["WIDTH"], top + place["HEIGHT"])
        self.picture().crop(area).save(path, optimize=True)
        print(path.relative_to(ROOT))

    def xdotool(self, *arguments):
        """Runs xdotool, for mouse and keyboard."""
        subprocess.run(["xdotool", *map(str, arguments)], env=self.environment, check=True)

    def move(self, x, y):
        """Moves the mouse in two steps: rviz looks for the object under it on each motion."""
        self.xdotool("mousemove", x - 3, y, "sleep", 0.3, "mousemove", x, y, "sleep", 0.5)

    def find(self, color):
        """The middle and the number of the pixels of this colour between toolbar and timeline."""
        difference = np.abs(np.asarray(self.picture()).astype(int) - color).max(axis=2)
        ys, xs = np.nonzero(difference[TOOLBAR:-TIMELINE] <= 45)
        return (round(xs.mean()), round(ys.mean()) + TOOLBAR) if len(xs) else None, len(xs)

    def wait_for(self, color, least):
        """Waits until so many pixels have a colour; returns their middle."""
        deadline = time.monotonic() + LIMIT
        while time.monotonic() < deadline:
            middle, count = self.find(color)
            if count >= least:
                return middle
            time.sleep(0.2)
        path = ROOT / "build" / "screenshots" / "failed.png"
        path.parent.mkdir(parents=True, exist_ok=True)
        self.picture().save(path)
        sys.exit(f"screenshots: waited {LIMIT:g} s for the colour {color}; see {path}")


def main():
    """Makes all pictures."""
    screen = Screen()
    launch = subprocess.Popen(
        ["roslaunch", "-p", str(PORT), "flatland_server", "server.launch"],
        env=screen.environment,
        stdout=subprocess.DEVNULL,
    )
    try:
        screen.wait_for(SCAN, 200)
        time.sleep(2)  # the first figures of the real-time factor
        screen.save("office")
        take_handles(screen, *take_spawning(screen))
    finally:
        launch.terminate()
        launch.wait()
        screen.close()


def take_spawning(screen):
    """A box at the cursor, being turned. Returns where it is put."""
    screen.move(520, 440)  # the map zooms here
    screen.xdotool("click", "--repeat", ZOOM_CLICKS, "--delay", 50, 4, "sleep", 1)
    x, y = screen.wait_for(ROBOT, 40)  # an arrow is on it
    screen.xdotool("key", "a", "sleep", 1.5, "key", "alt+f", "sleep", 0.2, "key", "ctrl+a")
    screen.xdotool("type", "--delay", 5, BOX)
    screen.xdotool("key", "Return", "sleep", 1.5)
    screen.move(x + 120, y - 60)
    screen.xdotool("mousedown", 1)
    screen.move(x + 160, y - 100)
    screen.save("spawn")
    screen.xdotool("mouseup", 1, "sleep", 1.5)
    return x + 120, y - 60


def take_handles(screen, x, y):
    """The ring around a model that is dragged from here, and its menu."""
    screen.move(x, y)
    screen.xdotool("mousedown", 1, "sleep", 0.3)
    for step in range(1, 11):
        screen.xdotool("mousemove", x - 2 * step, y - 8 * step, "sleep", 0.05)
    screen.xdotool("sleep", 0.3, "mouseup", 1, "sleep", 1)
    screen.move(x - 18, y - 78)
    screen.xdotool("click", 3, "sleep", 1)
    screen.save("handles")


main()
