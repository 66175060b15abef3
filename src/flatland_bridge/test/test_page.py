"""The page in a headless Chromium: what it shows, and what its users do."""

import math
import re
from pathlib import Path

import pytest
import yaml
from bridge_clients import ROBOT, Client, running
from browser_tab import CHROMIUM, ORANGE, RED, Tab, chromium
from PIL import Image
from waiting import wait_until

from flatland_bridge.server import ROSBRIDGE
from flatland_bridge.websocket_server import PAGE

WINDOW_PAGE = Path(__file__).resolve().parents[3] / "docs" / "window.md"
SCREENS = {
    "desktop": {"size": (1280, 800)},
    "phone": {"size": (390, 844), "is_dark": True, "is_touched": True},
}

pytestmark = [pytest.mark.slow, pytest.mark.skipif(CHROMIUM is None, reason="needs chromium")]


@pytest.fixture(scope="module")
def chromium_socket(tmp_path_factory):
    with chromium(tmp_path_factory.mktemp("chromium")) as socket:
        yield socket


@pytest.fixture
def open_tab(chromium_socket):
    """Opens tabs of one browser."""
    tabs = []

    def opened(**options):
        tabs.append(Tab(chromium_socket, **options))
        return tabs[-1]

    yield opened
    for tab in tabs:
        tab.call("Target.closeTarget", targetId=tab.target)


@pytest.fixture
def tab(open_tab):
    return open_tab()


def pose_of(server, name):
    """The present pose of a model."""
    return server.transport.call(lambda: server.manager.world.models[name].pose)


def wait_for_status(tab, text):
    wait_until(lambda: tab.text("status") == text, f'"{text}"')


@pytest.mark.parametrize("screen", SCREENS)
def test_models_are_driven_spawned_dragged_saved_and_undone(world, open_tab, screen):
    tab = open_tab(**SCREENS[screen])
    with running(world, state_folder=world.parent, with_history=True) as server:
        models = server.manager.world.models
        tab.open(server)
        assert tab.text("status") == "connected"

        tab.press("ArrowUp")
        wait_until(lambda: pose_of(server, "robot").x > 0.3, "the robot to drive")
        tab.press("ArrowUp", "keyUp")
        tab.press("t")
        tab.screenshot(f"{screen}_driven")
        tab.press(" ")
        wait_until(lambda: "Paused" in tab.text("banner"), "the pause")
        assert server.manager.is_paused

        tab.push("spawn")
        tab.click(*tab.pixel(0, 3))
        wait_for_status(tab, "robot_1 is spawned")
        wait_until(lambda: tab.of("robot", "length") == 2, "both robots in the list")
        assert pose_of(server, "robot_1") == pytest.approx((0, 3, 0), abs=0.05)

        wait_until(lambda: "robot_1" in tab.text("pose"), "its pose")
        before = tab.text("pose")
        tab.drag(tab.pixel(0, 3), tab.pixel(-2, 1))
        wait_for_status(tab, "robot_1 is moved")
        wait_until(lambda: tab.text("pose") not in ("", before), "another pose")
        assert pose_of(server, "robot_1") == pytest.approx((-2, 1, 0), abs=0.05)
        tab.drag(tab.pixel(-2, 1), tab.pixel(-2, 3), modifiers=8)
        wait_for_status(tab, "robot_1 is turned")
        assert pose_of(server, "robot_1").yaw == pytest.approx(1.57, abs=0.05)
        wait_until(lambda: tab.text("save") == "Save * 1", "the mark of a change")
        tab.screenshot(f"{screen}_spawned")

        tab.press("Ctrl+z")
        wait_for_status(tab, "Undone: Move robot_1")
        assert pose_of(server, "robot_1").yaw == pytest.approx(0, abs=0.05)
        tab.press("Ctrl+Shift+z")
        wait_for_status(tab, "Redone: Move robot_1")
        assert pose_of(server, "robot_1").yaw == pytest.approx(1.57, abs=0.05)
        tab.press("Ctrl+s")
        wait_for_status(tab, f"1 changed model saved in {world}")
        saved = yaml.safe_load(world.read_text())["models"]
        assert [model["name"] for model in saved] == ["robot", "robot_1"]
        wait_until(lambda: tab.text("save") == "Save", "no mark")

        tab.press("Delete")
        wait_until(lambda: len(models) == 1, "a model to be deleted")
        tab.press(" ")
        wait_until(lambda: tab.text("banner") == "", "the end of the pause")


def test_buttons_without_their_service_are_disabled(server, tab, monkeypatch):
    for name in ("/undo", "/redo"):
        monkeypatch.delitem(server.graph._services, name, raising=False)
    tab.open(server)

    wait_until(lambda: all(tab.of(name, "disabled") for name in ("undo", "redo", "save")), "that")
    assert tab.of("timeline", "hidden")


def test_an_infinite_rate_is_shown(world, tab):
    with running(world, rate=math.inf) as server:
        tab.open(server)
        wait_until(lambda: tab.of("rate", "value") == "max", "the rate")


def test_a_copy_is_saved_of_a_world_that_is_not_the_users(world, tab, tmp_path, monkeypatch):
    with running(world, state_folder=tmp_path, is_paused=True) as server:
        shipped = {"office": world}
        monkeypatch.setattr("flatland_server.config.worlds.shipped_worlds", lambda: shipped)
        tab.open(server)
        Client(server).call("/move_model", name="robot", pose={"x": 1.0})
        tab.press("Ctrl+s")
        wait_until(lambda: tab.call("Target.getTargets") and tab.dialog, "the question")
        assert "the world is one of Flatland's own; save a copy of it" in tab.dialog

        tab.call("Page.handleJavaScriptDialog", accept=True, promptText="copy.yaml")

        wait_for_status(tab, f"1 changed model saved in {tmp_path / 'copy.yaml'}")
    assert yaml.safe_load((tmp_path / "copy.yaml").read_text())["models"][0]["pose"] == [1, 0, 0]


def test_the_page_seeks_shows_old_scans_and_resumes_from_there(world, tab):
    with running(world, with_history=True) as server:
        tab.open(server)
        tab.press("ArrowUp")
        wait_until(lambda: pose_of(server, "robot").x > 1.0, "the robot to drive")
        tab.press("ArrowUp", "keyUp")
        tab.press("Alt+ArrowLeft")
        wait_until(lambda: "in the past" in tab.text("banner"), "the past")
        assert pose_of(server, "robot").x == 0.0
        wait_until(tab.returns, "the scan of that time")
        assert all(map(is_on_a_wall, tab.returns()))

        tab.press("ArrowUp")  # drives nothing there
        tab.press(".")
        wait_until(lambda: tab.text("clock") == "0.1 s, paused", "a step along the run")
        assert "in the past" in tab.text("banner")
        tab.press(",")
        wait_until(lambda: tab.text("clock") == "0.0 s, paused", "the way back")
        end = float(tab.of("slider", "max"))
        tab.value(f"slider.value = {end / 2}; slider.dispatchEvent(new Event('input'))")
        wait_until(lambda: 0 < pose_of(server, "robot").x < 1, "the time of the slider")
        tab.push("latest")
        wait_until(lambda: "in the past" not in tab.text("banner"), "the latest time")
        assert pose_of(server, "robot").x > 1.0
        tab.press("ArrowUp", "keyUp")

        tab.press("Alt+ArrowLeft")
        wait_until(lambda: "in the past" in tab.text("banner"), "the past")
        tab.press(" ")
        wait_until(lambda: not server.manager.is_paused, "the run to go on")
        assert server.manager.timekeeper.seconds < end


def test_time_is_sought_after_a_loss_of_the_connection(world, tab):
    def seek_begin():
        tab.value("slider.value = slider.min; slider.dispatchEvent(new Event('input'))")

    def has_past():
        return float(tab.of("slider", "max")) > 0.2 and not tab.of("timeline", "hidden")

    with running(world, with_history=True) as server:
        tab.open(server)
        wait_until(has_past, "a history")
        port = int(server.clients.url(ROSBRIDGE, "http").strip("/").rpartition(":")[2])
    wait_until(lambda: "Not connected" in tab.text("banner"), "the end of the connection")
    seek_begin()
    with running(world, with_history=True, rosbridge_port=port):
        wait_for_status(tab, "connected")
        wait_until(has_past, "a history")

        seek_begin()

        wait_until(lambda: "in the past" in tab.text("banner"), "the past")


def test_the_trail_shows_the_poses_of_the_odometry(world, tab):
    with running(world) as server:
        tab.open(server)
        tab.press("t")
        wait_until(lambda: tab.of("trail", "checked"), "the trail")
        tab.press("ArrowUp")
        wait_until(lambda: pose_of(server, "robot").x > 1.0, "the robot to drive")
        tab.press("ArrowUp", "keyUp")

        wait_until(lambda: any(0.3 < x < 0.6 for x, _ in tab.points(ORANGE)), "the trail")

        assert all(abs(y) < 0.1 for x, y in tab.points(ORANGE) if 0.3 < x < 0.6)


def test_keys_change_what_is_shown(world, tab, tmp_path):
    with running(world, is_paused=True, with_history=True) as server:
        client = Client(server)
        client.call("/spawn_model", yaml_path="robot.model.yaml", name="two", pose={"x": 3.0})
        tab.open(server, more="?follow=two")
        wait_until(lambda: tab.of("robot", "value") == "two", "the robot of the address")
        assert tab.of("follow", "checked")
        tab.press("Tab")
        wait_for_status(tab, "the keys drive robot")
        tab.press("F10")
        wait_until(lambda: server.manager.timekeeper.seconds == 0.005, "one step")
        tab.press(".")
        wait_until(lambda: server.manager.timekeeper.nanoseconds == 105_000_000, "0.1 s")
        receivers = server.graph._receivers
        wait_until(lambda: "/tf" in receivers or tab.returns(), "the lidar's frame to be missed")
        tab.press(".")
        wait_until(tab.returns, "a scan")
        tab.press("l")
        wait_until(lambda: not tab.returns(), "scans to be gone")
        tab.press("l")
        wait_until(tab.returns, "a scan, though time stands still")
        tab.press("l")
        tab.press("n")
        tab.press("f")
        assert not any(tab.of(name, "checked") for name in ("names", "follow", "scans"))
        tab.press("Home")
        tab.value("window.texts = {}")
        tab.press("Tab")
        wait_until(lambda: "two" in tab.value("window.texts"), "the chosen one's name")
        tab.value("window.texts = {}")
        tab.press("Home")
        wait_until(lambda: tab.value("window.texts"), "another picture")
        assert "robot" not in tab.value("window.texts")
        tab.press("+")
        wait_until(lambda: tab.of("rate", "value") == "2", "a higher rate")
        assert server.manager.rate == 2.0
        tab.press("-")
        wait_until(lambda: server.manager.rate == 1.0, "the former rate")
        tab.press("r")
        wait_for_status(tab, "the world is as it was loaded")
        assert "two" not in server.manager.world.models

        tab.press("F1")
        wait_until(lambda: tab.of("keys", "open"), "the keys")
        tab.screenshot("keys")
        tab.push("help")
        tab.call("Browser.setDownloadBehavior", behavior="allow", downloadPath=str(tmp_path))
        tab.press("Ctrl+p")
        wait_until(lambda: list(tmp_path.glob("flatland_*.png")), "the picture")
        with Image.open(next(tmp_path.glob("flatland_*.png"))) as picture:
            assert picture.width == 900


def ground(tab):
    """The colour of a pixel at the edge of the view: red, green, blue."""
    data = "document.getElementById('view').getContext('2d').getImageData(2, 2, 1, 1).data"
    return tab.value(f"Array.from({data}).slice(0, 3)")


def test_the_look_is_that_of_the_system_until_the_user_chooses(server, open_tab):
    tab = open_tab(is_dark=True)
    tab.open(server)
    assert max(ground(tab)) < 40
    tab.push("look")
    wait_until(lambda: min(ground(tab)) > 220, "the light look")
    tab.open(server)
    assert min(ground(tab)) > 220
    tab.push("look")
    wait_until(lambda: max(ground(tab)) < 40, "the dark look")


def test_fingers_drive_and_zoom(world, open_tab):
    tab = open_tab(**SCREENS["phone"])
    with running(world) as server:
        tab.open(server)
        pad = "document.querySelector('#pad [data-key=ArrowUp]').getBoundingClientRect()"
        tab.touch("Start", tab.value(f"[{pad}.x + 20, {pad}.y + 20]"))
        wait_until(lambda: pose_of(server, "robot").x > 0.2, "the robot to drive")
        tab.touch("End")
        wait_until(lambda: moves(server) is False, "the robot to stop")

        grey = "Math.max(red, green, blue) - Math.min(red, green, blue) < 5 && red > 100"
        walls = f"({grey}) || ({RED})"  # a scan may cover them
        wait_until(lambda: any(x > 4.8 for x, _ in tab.points(walls)), "the right wall")
        (x, y), apart = tab.pixel(-4, 0), 30
        tab.touch("Start", (x - apart, y), (x + apart, y))
        tab.touch("Move", (x - 3 * apart, y), (x + 3 * apart, y))
        tab.touch("End")
        wait_until(lambda: not any(x > 4.8 for x, _ in tab.points(walls)), "it to be out of view")
        tab.screenshot("phone_zoomed")


def moves(server):
    """True while the robot moves."""
    base = server.manager.world.models["robot"].base
    return server.transport.call(lambda: any(base.physics_body.velocity))


def test_a_robot_stops_when_its_tab_is_closed(world, open_tab):
    with running(world) as server:
        one, other = open_tab(), open_tab()
        other.open(server)
        one.open(server)
        one.press("ArrowUp")
        wait_until(lambda: moves(server), "the robot to drive")

        one.call("Page.navigate", url="about:blank")

        wait_until(lambda: not moves(server), "the robot to stop")
        assert other.text("status") == "connected"


def test_with_many_robots_only_the_chosen_ones_scan_is_asked_for(world, tab):
    with running(world, is_paused=True) as server:
        client = Client(server)
        for number in range(24):
            pose = {"x": number % 5 - 2.0, "y": number // 5 - 4.0}
            name = f"r{number}"
            client.call("/spawn_model", yaml_path="robot.model.yaml", name=name, ns=name, pose=pose)
        tab.open(server, more="?follow=r3")

        wait_until(lambda: "/r3/scan" in server.graph._receivers, "the subscription")
        scans = [topic for topic in server.graph._receivers if topic.endswith("scan")]
        assert scans == ["/r3/scan"]


def is_on_a_wall(point):
    return any(abs(each - 5) < 0.15 for each in point)


@pytest.mark.parametrize("transforms", ["", "static_tf: true"])
@pytest.mark.parametrize("namespace", ["", "r1"])
def test_scans_are_drawn_where_the_robot_was(world, tab, transforms, namespace):
    model = ROBOT.replace("update_rate: 20", f"update_rate: 20\n    {transforms}")
    (world.parent / "robot.model.yaml").write_text(model)
    world.write_text(
        world.read_text().replace("name: robot,", f"name: robot, namespace: '{namespace}',")
    )
    with running(world, tf_by_namespace=True) as server:
        client = Client(server)
        topic = f"/{namespace}/cmd_vel" if namespace else "/cmd_vel"
        client.send("publish", topic=topic, msg={"angular": {"z": 1.5}})
        tab.open(server)
        wait_until(tab.returns, "a scan")
        for _ in range(20):
            assert all(map(is_on_a_wall, tab.returns()))

        client.call("/pause")
        client.call("/move_model", name="robot", pose={"x": -3.0, "y": -3.0})
        tab.returns()
        assert all(map(is_on_a_wall, tab.returns()))


def test_robots_have_names_and_that_of_the_keys_is_marked(world, tab):
    with running(world, is_paused=True) as server:
        client = Client(server)
        client.call("/spawn_model", yaml_path="robot.model.yaml", name="two", pose={"x": 3.0})
        tab.open(server)
        wait_until(lambda: {"robot", "two"} <= tab.value("window.texts").keys(), "the names")
        assert "bold" in tab.value("window.texts.robot")
        assert "bold" not in tab.value("window.texts.two")

        tab.click(*tab.pixel(3, 0))

        wait_for_status(tab, "the keys drive two")
        wait_until(lambda: "bold" in tab.value("window.texts.two"), "the mark")
        assert "bold" not in tab.value("window.texts.robot")


def test_a_spawn_into_a_wall_is_a_warning(world, tab):
    with running(world, is_paused=True) as server:
        tab.open(server)
        tab.push("spawn")
        tab.click(*tab.pixel(5, 1))

        wait_until(lambda: "robot_1" in server.manager.world.models, "the model")
        wait_until(lambda: tab.of("status", "className") == "warning", "the warning")
        assert 'overlaps the layer "hall"' in tab.text("status")


def test_the_help_and_the_documentation_have_the_same_keys():
    row = r"<tr><td>(.+?)</td><td>(.+?)</td></tr>"
    keys = re.findall(row, (PAGE / "index.html").read_text(encoding="utf-8"))
    rows = re.findall(r"^\| (.+?) \|.*\| (.+?) \|$", WINDOW_PAGE.read_text(), re.MULTILINE)

    assert len(keys) > 20
    assert [key for key in keys if key not in rows] == []
