"""A tab of a headless Chromium, driven by the protocol of its DevTools."""

import base64
import itertools
import json
import re
import shutil
import subprocess
from contextlib import contextmanager
from pathlib import Path

from bridge_clients import connect
from waiting import wait_until

from flatland_bridge.server import ROSBRIDGE

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser"))), None)
SCREENSHOTS = Path(__file__).resolve().parents[3] / "build" / "screenshots"

RECORD_TEXTS = """
const write = CanvasRenderingContext2D.prototype.fillText;
window.texts = {};  // fonts of the texts in the canvas
CanvasRenderingContext2D.prototype.fillText = function (text, ...rest) {
  window.texts[text] = this.font;
  write.call(this, text, ...rest);
};
"""
POINTS = """(() => {
  const view = document.getElementById("view"), {x, y} = view.getBoundingClientRect();
  const {data, width} = view.getContext("2d").getImageData(0, 0, view.width, view.height);
  const points = [], ratio = devicePixelRatio;
  for (let i = 0; i < data.length; i += 4) {
    const [red, green, blue] = data.slice(i, i + 3);
    if (CONDITION) points.push([x + i / 4 % width / ratio, y + Math.floor(i / 4 / width) / ratio]);
  }
  return points;
})()"""
RED, ORANGE = "red > 200 && green < 100 && blue < 100", "red > 200 && green > 110 && blue < 60"
MODIFIERS = {"Alt": 1, "Ctrl": 2, "Shift": 8}


class Tab:
    """A tab, with a window of its own.

    Args:
        socket: the browser's socket.
        size: the window's size [px].
        is_dark: the look that the user prefers.
        is_touched: whether it is a phone.
    """

    def __init__(self, socket, size=(900, 600), is_dark=False, is_touched=False):
        self._socket = socket
        self._session = ""
        self._numbers = itertools.count(1)
        self.target = self.call("Target.createTarget", url="about:blank", newWindow=True)[
            "targetId"
        ]
        session = self.call("Target.attachToTarget", targetId=self.target, flatten=True)
        self._session = session["sessionId"]
        self.call("Page.enable")
        look = {"name": "prefers-color-scheme", "value": "dark" if is_dark else "light"}
        self.call("Emulation.setEmulatedMedia", features=[look])
        self.call("Emulation.setTouchEmulationEnabled", enabled=is_touched)
        self.call(
            "Emulation.setDeviceMetricsOverride",
            **dict(zip(("width", "height"), size)),
            deviceScaleFactor=2 if is_touched else 1,
            mobile=is_touched,
        )
        self.call("Page.addScriptToEvaluateOnNewDocument", source=RECORD_TEXTS)

    def call(self, method, **params):
        number = next(self._numbers)
        call = {"id": number, "method": method, "params": params}
        if self._session:
            call["sessionId"] = self._session
        self._socket.send(json.dumps(call))
        while True:
            message = json.loads(self._socket.recv(timeout=60))
            if message.get("id") == number:
                return message["result"]
            if message.get("method") == "Page.javascriptDialogOpening":
                self.dialog = message["params"]["message"]

    dialog = ""
    """The text of the last dialog of a script."""

    def value(self, expression):
        """The value of an expression in the page."""
        answer = self.call("Runtime.evaluate", expression=expression, returnByValue=True)
        return answer["result"].get("value")

    def of(self, name, property):
        """A property of an element."""
        return self.value(f"document.getElementById('{name}').{property}")

    def text(self, name):
        return self.of(name, "textContent")

    def push(self, name):
        """Pushes a button."""
        self.of(name, "click()")

    def press(self, keys, kind="keyDown"):
        """Presses a key, with those that modify it: Ctrl+Shift+z."""
        *modifiers, key = re.split(r"(?<=\w)\+", keys)
        modifiers = sum(MODIFIERS[each] for each in modifiers)
        self.call("Input.dispatchKeyEvent", type=kind, key=key, modifiers=modifiers)

    def open(self, server, more=""):
        """Opens the page, and waits for the world in it."""
        self.call("Page.navigate", url=server.clients.url(ROSBRIDGE, "http") + more)
        wait_until(lambda: self.of("robot", "value"), "the robot")
        wait_until(lambda: self.value("window.texts.robot"), "the robot's picture")

    def pixel(self, x, y):
        """The pixel of a point of the world, as long as the view is as at first."""
        left, top, width, height = self.value(
            "(({x, y, width, height}) => [x, y, width, height])"
            "(document.getElementById('view').getBoundingClientRect())"
        )
        scale = 0.95 * min(width, height) / 10  # WORLD is 10 m wide and high
        return left + width / 2 + x * scale, top + height / 2 - y * scale

    def points(self, condition):
        """The points of the world that are drawn in a colour."""
        (left, top), (right, _) = self.pixel(0, 0), self.pixel(1, 0)
        return [
            ((x - left) / (right - left), (top - y) / (right - left))
            for x, y in self.value(POINTS.replace("CONDITION", condition))
        ]

    def returns(self):
        """The points of the world that are drawn as a scan's."""
        return self.points(RED)

    def mouse(self, kind, x, y, modifiers=0):
        self.call(
            "Input.dispatchMouseEvent",
            type=f"mouse{kind}",
            x=x,
            y=y,
            button="left",
            clickCount=1,
            modifiers=modifiers,
        )

    def click(self, x, y):
        self.drag((x, y), (x, y))

    def drag(self, begin, end, modifiers=0):
        """Drags from one pixel to another."""
        self.mouse("Pressed", *begin, modifiers)
        if begin != end:
            self.mouse("Moved", *end, modifiers)
        self.mouse("Released", *end, modifiers)

    def touch(self, kind, *points):
        """Touches pixels: kind is Start, Move, or End without any."""
        places = [{"x": x, "y": y, "id": number} for number, (x, y) in enumerate(points)]
        self.call("Input.dispatchTouchEvent", type=f"touch{kind}", touchPoints=places)

    def screenshot(self, name):
        """Saves a picture of the page, to look at."""
        SCREENSHOTS.mkdir(parents=True, exist_ok=True)
        data = self.call("Page.captureScreenshot", format="png")["data"]
        (SCREENSHOTS / f"page_{name}.png").write_bytes(base64.b64decode(data))


@contextmanager
def chromium(folder):
    """A browser with a profile in a folder; the context is its socket."""
    options = ["--headless", "--no-sandbox", "--disable-gpu", "--remote-debugging-port=0"]
    process = subprocess.Popen(
        [CHROMIUM, *options, f"--user-data-dir={folder}/profile"], stderr=subprocess.PIPE, text=True
    )
    try:
        found = next(filter(None, (re.search(r"ws://\S+", line) for line in process.stderr)))
        with connect(found[0], max_size=None) as socket:
            yield socket
    finally:
        process.kill()
        process.wait()
