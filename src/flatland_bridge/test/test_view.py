"""The command `flatland view`: the page's address, who may connect, what is saved, and the end."""

import json
import os
import re
import signal
import subprocess
import sys
from contextlib import contextmanager

import pytest
from bridge_clients import Client, connect
from waiting import wait_until
from websockets.exceptions import InvalidStatus

from flatland2d.cli import main
from flatland_server.config import find_world

pytestmark = pytest.mark.slow


@contextmanager
def view(world, folder, *arguments, **environment):
    """The command as a process in a folder; the context is it and its page's address."""
    screens = ("BROWSER", "DISPLAY", "WAYLAND_DISPLAY")
    kept = {name: value for name, value in os.environ.items() if name not in screens}
    process = subprocess.Popen(
        [sys.executable, "-m", "flatland2d", "view", str(world), *arguments],
        cwd=folder,
        env={**kept, **environment},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        yield process, re.fullmatch("page: (http://.*)\n", process.stdout.readline())[1]
    finally:
        process.kill()
        process.wait()


def client_of(page):
    """A client of rosbridge at a page's address."""

    class Printed:
        class clients:
            url = staticmethod(lambda name, scheme: page.partition("&")[0].replace("http", scheme))

    return Client(Printed)


def test_it_opens_the_browser_and_ends_by_ctrl_c(world, tmp_path):
    browser = tmp_path / "browser"
    browser.write_text(f"#!/bin/sh\ncd {tmp_path}\necho $1 > opened.part\nmv opened.part opened\n")
    browser.chmod(0o755)
    with view(world, tmp_path, "--follow", "robot", BROWSER=f"{browser} %s") as (process, page):
        wait_until((tmp_path / "opened").exists, "the browser")
        assert (tmp_path / "opened").read_text() == f"{page}\n"
        assert page.endswith("&follow=robot")
        state = client_of(page).subscribed("/flatland_server/state")
        assert state.next_of("/flatland_server/state")["rate"] == 1.0

        process.send_signal(signal.SIGINT)

        assert process.wait(20) == 0
        assert process.stderr.read() == ""


def test_without_a_screen_view_says_so_and_serves_on(world, tmp_path):
    with view(world, tmp_path) as (process, page):
        client = client_of(page)
        assert client.call("/seek", time=0.0)["values"]["success"]
        assert client.call("/step", steps=1)["values"]["success"]
        process.send_signal(signal.SIGTERM)

        assert process.wait(20) == 0
        assert process.stderr.read() == ("no browser can be opened here: open the address in one\n")


def test_other_pages_and_other_users_programs_are_rejected(world, tmp_path):
    with view(world, tmp_path) as (_, page):
        url = page.replace("http", "ws")
        for origin in ("http://evil.example", "null"):
            with pytest.raises(InvalidStatus, match="403"):
                connect(url, origin=origin)
        for wrong in (url.partition("?")[0], url[:-1]):
            with pytest.raises(InvalidStatus, match="401"):
                connect(wrong)
            with pytest.raises(InvalidStatus, match="401"):
                connect(wrong, origin="http://localhost:8000")


def test_moved_models_are_saved_in_the_users_world(world, tmp_path):
    with view(world, tmp_path) as (_, page):
        client = client_of(page)
        client.call("/move_model", name="robot", pose={"x": 1.5})
        saved = client.call("/save_world")["values"]
    assert saved == {"success": True, "message": f"1 changed model saved in {world}"}
    assert "pose: [1.5, 0.0, 0.0]" in world.read_text()


@pytest.mark.parametrize("by_path", [False, True])
def test_a_shipped_world_is_saved_as_a_copy_in_the_cwd(tmp_path, by_path):
    world = os.path.relpath(find_world("office"), tmp_path) if by_path else "office"
    with view(world, tmp_path) as (_, page):
        client = client_of(page)
        client.call("/move_model", name="turtlebot", pose={"x": 1.5})
        refused = [
            client.call("/save_world", path=path)["values"]["message"]
            for path in ("", "../there.yaml", "/tmp/there.yaml")
        ]
        saved = client.call("/save_world", path="mine.yaml")["values"]
    assert "the world is one of Flatland's own; save a copy of it" in refused[0]
    assert all("expected a file in the folders" in each for each in refused[1:])
    assert saved["success"], saved
    assert os.listdir(tmp_path) == ["mine.yaml"]


def test_two_views_see_the_same_and_one_may_leave(world, tmp_path):
    with view(world, tmp_path) as (_, page):
        one, other = client_of(page), client_of(page)
        other.subscribed("/flatland_server/models")
        assert len(other.next_of("/flatland_server/models")["models"]) == 1
        one.call("/spawn_model", yaml_path="robot.model.yaml", name="two", ns="two")
        assert len(other.next_of("/flatland_server/models")["models"]) == 2
        one.socket.close()
        other.send("call_service", service="/pause", id="last")
        answer = other.receive_until(lambda each: each.get("id") == "last")
        assert json.dumps(answer["result"]) == "true"


def test_a_robot_to_follow_must_be_there(world, capsys):
    assert main(["view", str(world), "--follow", "robt"]) == 1
    assert 'there is no model "robt" (did you mean "robot"?)' in capsys.readouterr().err
