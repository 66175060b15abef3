"""The page of `flatland serve` in a headless Chromium, driven by the protocol of its DevTools."""

import itertools
import json
import re
import shutil
import subprocess

import pytest
from bridge_clients import ROBOT, Client, connect, running
from waiting import wait_until

from flatland_bridge.server import ROSBRIDGE

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser"))), None)

RECORD_TEXTS = """
const write = CanvasRenderingContext2D.prototype.fillText;
window.texts = {};  // fonts of the texts in the canvas
CanvasRenderingContext2D.prototype.fillText = function (text, ...rest) {
  window.texts[text] = this.font;
  write.call(this, text, ...rest);
};
"""
RETURNS = """(() => {
  const view = document.getElementById("view"), {x, y} = view.getBoundingClientRect();
  const {data, width} = view.getContext("2d").getImageData(0, 0, view.width, view.height);
  const points = [];
  for (let i = 0; i < data.length; i += 4) {
    if (data[i] > 200 && data[i + 1] < 80 && data[i + 2] < 80) {
      points.push([x + i / 4 % width, y + Math.floor(i / 4 / width)]);
    }
  }
  return points;
})()"""

pytestmark = [pytest.mark.slow, pytest.mark.skipif(CHROMIUM is None, reason="needs chromium")]


class Browser:
    """A tab of a browser."""

    def __init__(self, socket):
        self._socket = socket
        self._session = ""
        self._numbers = itertools.count(1)
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        session = self.call("Target.attachToTarget", targetId=target, flatten=True)
        self._session = session["sessionId"]

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

    def value(self, expression):
        """The value of an expression in the page."""
        answer = self.call("Runtime.evaluate", expression=expression, returnByValue=True)
        return answer["result"].get("value")

    def text(self, name):
        return self.value(f"document.getElementById('{name}').textContent")

    def press(self, key, kind="keyDown"):
        self.call("Input.dispatchKeyEvent", type=kind, key=key)

    def open(self, server):
        """Opens the page, and waits for the world in it."""
        self.call("Page.enable")
        self.call("Page.addScriptToEvaluateOnNewDocument", source=RECORD_TEXTS)
        self.call("Page.navigate", url=server.clients.url(ROSBRIDGE, "http"))
        wait_until(lambda: self.value("document.getElementById('robot').value"), "the robot")

    def pixel(self, x, y):
        """Where a point of the world is, as long as the view is as at first."""
        left, top, width, height = self.value(
            "(({x, y, width, height}) => [x, y, width, height])"
            "(document.getElementById('view').getBoundingClientRect())"
        )
        scale = 0.95 * min(width, height) / 10  # WORLD is 10 m wide and high
        return left + width / 2 + x * scale, top + height / 2 - y * scale

    def returns(self):
        """The points of the world that are drawn as a scan's."""
        (left, top), (right, _) = self.pixel(0, 0), self.pixel(1, 0)
        return [
            ((x - left) / (right - left), (top - y) / (right - left))
            for x, y in self.value(RETURNS)
        ]

    def click(self, x, y):
        for kind in ("mousePressed", "mouseReleased"):
            self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)


@pytest.fixture
def browser(tmp_path):
    options = ["--headless", "--no-sandbox", "--disable-gpu", "--window-size=900,600"]
    process = subprocess.Popen(
        [CHROMIUM, *options, "--remote-debugging-port=0", f"--user-data-dir={tmp_path}/profile"],
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        found = next(filter(None, (re.search(r"ws://\S+", line) for line in process.stderr)))
        with connect(found[0], max_size=None) as socket:
            yield Browser(socket)
    finally:
        process.kill()
        process.wait()


def test_the_page_shows_the_world_and_drives_and_spawns(world, browser):
    with running(world) as server:
        models = server.manager.world.models
        browser.open(server)
        assert browser.text("status") == "connected"

        browser.press("ArrowUp")
        wait_until(
            lambda: server.transport.call(lambda: models["robot"].pose.x) > 0.3,
            "the robot to drive",
        )
        browser.press("ArrowUp", "keyUp")

        browser.press(" ")
        wait_until(lambda: "Paused" in browser.text("banner"), "the pause")
        assert server.manager.is_paused

        browser.value("document.getElementById('spawn').click()")
        browser.click(600, 250)
        wait_until(lambda: "robot_1" in models, "the new model")
        wait_until(lambda: browser.value("document.getElementById('robot').length") == 2, "both")
        wait_until(lambda: browser.text("status") == "robot_1 is spawned", "the words")
        browser.press("Delete")
        wait_until(lambda: len(models) == 1, "a model to be deleted")
        browser.press(" ")
        wait_until(lambda: browser.text("banner") == "", "the end of the pause")


def is_on_a_wall(point):
    return any(abs(each - 5) < 0.15 for each in point)


@pytest.mark.parametrize("transforms", ["", "static_tf: true"])
@pytest.mark.parametrize("namespace", ["", "r1"])
def test_scans_are_drawn_where_the_robot_was(world, browser, transforms, namespace):
    model = ROBOT.replace("update_rate: 20", f"update_rate: 20\n    {transforms}")
    (world.parent / "robot.model.yaml").write_text(model)
    world.write_text(
        world.read_text().replace("name: robot,", f"name: robot, namespace: '{namespace}',")
    )
    with running(world, tf_by_namespace=True) as server:
        client = Client(server)
        topic = f"/{namespace}/cmd_vel" if namespace else "/cmd_vel"
        client.send("publish", topic=topic, msg={"angular": {"z": 1.5}})
        browser.open(server)
        wait_until(browser.returns, "a scan")
        for _ in range(20):
            assert all(map(is_on_a_wall, browser.returns()))

        client.call("/pause")
        client.call("/move_model", name="robot", pose={"x": -3.0, "y": -3.0})
        browser.returns()
        assert all(map(is_on_a_wall, browser.returns()))


def test_robots_have_names_and_that_of_the_keys_is_marked(world, browser):
    with running(world, is_paused=True) as server:
        client = Client(server)
        client.call("/spawn_model", yaml_path="robot.model.yaml", name="two", pose={"x": 3.0})
        browser.open(server)
        wait_until(lambda: {"robot", "two"} <= browser.value("window.texts").keys(), "the names")
        assert "bold" in browser.value("window.texts.robot")
        assert "bold" not in browser.value("window.texts.two")

        browser.click(*browser.pixel(3, 0))

        wait_until(lambda: browser.text("status") == "the keys drive two", "the choice")
        wait_until(lambda: "bold" in browser.value("window.texts.two"), "the mark")
        assert "bold" not in browser.value("window.texts.robot")


def test_a_spawn_into_a_wall_is_a_warning(world, browser):
    with running(world, is_paused=True) as server:
        browser.open(server)
        browser.value("document.getElementById('spawn').click()")
        browser.click(*browser.pixel(5, 1))

        wait_until(lambda: "robot_1" in server.manager.world.models, "the model")
        wait_until(
            lambda: browser.value("document.getElementById('status').className") == "warning",
            "the warning",
        )
        assert 'overlaps the layer "hall"' in browser.text("status")
