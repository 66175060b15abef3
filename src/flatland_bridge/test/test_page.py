"""The page of `flatland serve` in a headless Chromium, driven by the protocol of its DevTools."""

import itertools
import json
import re
import shutil
import subprocess

import pytest
from bridge_clients import connect, running
from waiting import wait_until

from flatland_bridge.server import ROSBRIDGE

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser"))), None)

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
        return self.call("Runtime.evaluate", expression=expression)["result"].get("value")

    def text(self, name):
        return self.value(f"document.getElementById('{name}').textContent")

    def press(self, key, kind="keyDown"):
        self.call("Input.dispatchKeyEvent", type=kind, key=key)

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
        browser.call("Page.navigate", url=server.clients.url(ROSBRIDGE, "http"))
        wait_until(lambda: browser.value("document.getElementById('robot').value"), "the robot")
        assert browser.text("status") == "connected"

        browser.press("ArrowUp")
        wait_until(
            lambda: server.transport.call(lambda: models["robot"].pose.x) > 0.3,
            "the robot to drive",
        )
        browser.press("ArrowUp", "keyUp")

        browser.press(" ")
        wait_until(lambda: "paused" in browser.text("clock"), "the pause")
        assert server.manager.is_paused

        browser.value("document.getElementById('spawn').click()")
        browser.click(600, 250)
        wait_until(lambda: "robot_1" in models, "the new model")
        wait_until(lambda: browser.value("document.getElementById('robot').length") == 2, "both")
        browser.press("Delete")
        wait_until(lambda: len(models) == 1, "a model to be deleted")
