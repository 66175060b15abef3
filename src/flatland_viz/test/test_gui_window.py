"""The window's menus and panels on a desktop with a window manager, by keys and mouse.

The server's topics and services have the results.
"""

import re
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from desktop import desktop

pytestmark = pytest.mark.slow

WALLS = (102, 102, 102)
KNOB = (60, 130, 196)  # colour of the pad's knob
STATES = {"paused": (240, 196, 25), "no server": (198, 40, 40)}
WORLDS = Path(__file__).resolve().parents[2] / "flatland_server" / "worlds"
ROBOT = WORLDS / "office" / "turtlebot.model.yaml"
BOX = WORLDS / "office" / "box.model.yaml"
WORLD = f"""properties: {{}}
layers:
  - {{name: room, map: {WORLDS}/test_room/room.yaml, color: [0.4, 0.4, 0.4, 1]}}
models:
  - {{name: turtlebot, pose: [0, 0, 0], model: {ROBOT}}}
"""


@pytest.fixture(scope="module")
def display():
    with desktop("1280x800") as name:
        yield name


class Window:
    """The window with a world of one robot, which can be edited."""

    def __init__(self, screen, ros, waiting, folder):
        self.screen, self.ros, self.waiting = screen, ros, waiting
        self.world = folder / "room" / "world.yaml"
        self.world.parent.mkdir()
        self.world.write_text(WORLD)
        ros.launch_server(self.world, "show_viz:=true")
        self.id = screen.wait_for_window("Flatland - room/world.yaml")
        waiting(self.shows_walls, "the walls")

    def shows_walls(self):
        pixels = self.screen.picture("window_first")
        return (abs(pixels - WALLS).max(axis=2) < 10).sum() > 2000

    def key(self, *keys):
        """Keys for the window, not for one of its dialogs."""
        self.screen.focus(self.id)
        self.screen.key(*keys)

    def press(self, key):
        """A key of one of rviz's tools: with the mouse over the view."""
        self.screen.focus(self.id)
        self.screen.move((690, 260))
        self.screen.move((700, 250))
        self.screen.key(key)

    def wait_for_dialog(self, title):
        self.screen.wait_for_window(title)

    def wait_for_state(self, **values):
        def holds():
            state = self.ros.state()
            return all(state[name] == value for name, value in values.items())

        self.waiting(holds, str(values), 20)

    def says(self, state):
        """Whether the status line shows a state of the simulation, by its background."""
        line = self.screen.picture("window_status")[-60:, 640:]
        return (abs(line - np.array(STATES[state])).max(axis=2) < 6).sum() > 200

    def find_knob(self):
        """The middle of the Drive panel's pad at rest; None if it is not shown."""
        right = self.screen.picture("window_knob")[:, 900:]
        ys, xs = np.nonzero(abs(right - KNOB).max(axis=2) < 3)
        return (900 + xs.mean(), ys.mean()) if 300 < len(xs) < 1500 else None

    @contextmanager
    def held(self, key):
        """A key is held down."""
        self.screen.focus(self.id)
        self.screen.xdotool("keydown", key)
        try:
            yield
        finally:
            self.screen.xdotool("keyup", key)

    def command(self):
        """Speed [m/s] and turn [rad/s] that are commanded now."""
        twist = self.ros.message("/cmd_vel", "geometry_msgs/Twist")
        return twist["linear"]["x"], twist["angular"]["z"]

    def wait_for_rest(self):
        def rests():
            odometry = self.ros.message("/odometry/ground_truth", "nav_msgs/Odometry")
            twist = odometry["twist"]["twist"]
            return abs(twist["linear"]["x"]) + abs(twist["angular"]["z"]) < 1e-3

        self.waiting(rests, "the robot to stop", 20)

    def wait_for_models(self, *names):
        self.waiting(lambda: self.ros.models() == [*names], f"the models {names}", 20)


@pytest.fixture(scope="module")
def window(screen, ros, waiting, tmp_path_factory):
    return Window(screen, ros, waiting, tmp_path_factory.mktemp("worlds"))


@pytest.fixture
def paused(window):
    window.ros.call("/pause")
    window.wait_for_state(paused=True)
    yield window
    window.ros.call("/resume")
    window.wait_for_state(paused=False)


def test_the_window_fits_on_the_screen_with_its_title_bar(window):
    [line] = [
        line
        for line in window.screen.text("xwininfo", "-id", window.id, "-stats", "-frame")
        if "-geometry" in line
    ]
    width, height, x, y = map(int, re.findall(r"\d+", line))
    assert x + width <= 1280
    assert y + height <= 800
    assert width > 1200
    assert height > 700


def test_reset_starts_again(paused):
    paused.ros.spawn(BOX, "crate", 2.0, 1.0)
    assert paused.ros.state()["stamp"] > 0.0
    paused.key("ctrl+r")
    paused.wait_for_state(stamp=0.0)
    paused.wait_for_models("turtlebot")
    paused.screen.picture("window_reset")


def test_single_steps_and_several(paused):
    before = paused.ros.state()["stamp"]
    paused.waiting(lambda: paused.says("paused"), '"paused" in the status line', 20)
    paused.key("F10")
    paused.wait_for_state(stamp=pytest.approx(before + 0.005))
    paused.key("shift+F10")
    paused.wait_for_dialog("Steps")
    paused.screen.key("ctrl+a")
    paused.screen.type("20")
    paused.screen.picture("window_steps")
    paused.screen.key("Return")
    paused.wait_for_state(stamp=pytest.approx(before + 0.105))


def test_files_are_reloaded_after_an_edit(window):
    crate = f"  - {{name: crate, pose: [2, 1, 0], model: {BOX}}}\n"
    window.world.write_text(WORLD + crate)
    window.key("F5")
    window.wait_for_models("turtlebot", "crate")

    window.world.write_text(WORLD + crate.replace("pose", "pos"))
    window.key("F5")
    window.wait_for_dialog("Flatland")
    window.screen.picture("window_refused")
    window.screen.key("Escape")
    window.screen.wait_until_closed("Flatland")
    assert window.ros.models() == ["turtlebot", "crate"]

    window.world.write_text(WORLD)
    window.key("F5")
    window.wait_for_models("turtlebot")


def is_drawn(window, name):
    """Whether a dialog with a white list is drawn in the middle of the screen."""
    middle = window.screen.picture(name)[240:480, 440:940]
    return (middle > 250).all(axis=2).mean() > 0.4


def test_another_world_is_opened_and_the_first_one_again(window):
    other = WORLDS / "test_room" / "world.yaml"
    window.key("ctrl+o")
    window.wait_for_dialog("Open a World")
    window.waiting(lambda: is_drawn(window, "window_open"), "the dialog to be drawn", 20)
    window.screen.type(str(other))
    window.screen.picture("window_open")

    def is_closed():
        if window.screen.windows("Open a World"):
            window.screen.key("Return")  # or it takes a completion of the name, and closes that
        return not window.screen.windows("Open a World")

    window.waiting(is_closed, "the dialog to close", 20)
    window.screen.wait_for_window("Flatland - test_room/world.yaml")
    topics = "/flatland_server/debug/topics"
    assert "layer/hall" in window.ros.message(topics, "flatland_msgs/DebugTopicList")["topics"]

    window.key("alt+w", "r")  # the menu of recent worlds
    window.screen.picture("window_recent")
    window.screen.key("Return")
    window.screen.wait_for_window("Flatland - room/world.yaml")


def test_a_spawn_that_was_refused_is_tried_again_at_its_place(window):
    window.press("a")
    window.wait_for_dialog("Spawn Model")
    window.screen.key("alt+f", "ctrl+a")
    window.screen.type(BOX)
    window.screen.key("alt+n", "ctrl+a")
    window.screen.type("turtlebot")
    window.screen.key("Return")
    window.screen.wait_until_closed("Spawn Model")
    for place in ((700, 250), (800, 250)):
        window.screen.click(place)
    window.wait_for_dialog("Spawn Model")  # the name is taken
    window.screen.picture("window_taken")
    window.screen.type("crate")  # the name is selected
    window.screen.key("Return")
    window.screen.wait_until_closed("Spawn Model")
    window.wait_for_models("turtlebot", "crate")
    x, y, yaw = window.ros.pose("crate")
    window.screen.picture("window_spawned")
    assert x > 1.0
    assert y > 0.5
    assert yaw == pytest.approx(0.0, abs=0.02)
    window.ros.call("/delete_model", name="crate")


def test_a_second_robot_gets_a_name_and_a_namespace_of_its_own(window):
    window.press("a")
    window.wait_for_dialog("Spawn Model")
    window.screen.key("alt+f", "ctrl+a")
    window.screen.type(ROBOT)
    window.screen.key("Tab")
    window.screen.picture("window_second")
    window.screen.key("Return")
    window.screen.wait_until_closed("Spawn Model")
    for place in ((700, 250), (800, 250)):
        window.screen.click(place)
    window.wait_for_models("turtlebot", "turtlebot_2")
    models = window.ros.message("/flatland_server/models", "flatland_msgs/ModelList")["models"]
    assert [(model["name"], model["ns"]) for model in models] == [
        ("turtlebot", ""),
        ("turtlebot_2", "turtlebot_2"),
    ]
    window.ros.call("/delete_model", name="turtlebot_2")


@pytest.fixture
def drive(window):
    """The window with the Drive panel, and the robot at rest."""
    window.ros.call("/reset", keep_time=False)
    window.key("F4")
    window.waiting(window.find_knob, "the pad", 20)
    yield window
    window.screen.xdotool("keyup", "Up", "keyup", "a")
    window.key("F4")
    window.waiting(lambda: not window.find_knob(), "the panel to close", 20)


def test_a_robot_is_driven_by_keys_and_stops_when_they_are_released(drive):
    x, _, yaw = drive.ros.pose("turtlebot")
    with drive.held("Up"):
        assert drive.command() == (0.5, 0.0)
        drive.waiting(lambda: drive.ros.pose("turtlebot")[0] > x + 0.1, "the robot to move", 20)
        drive.screen.picture("window_drive")
    drive.wait_for_rest()
    with drive.held("a"):  # elsewhere the key of Spawn Model
        assert drive.command() == (0.0, 1.0)
    drive.wait_for_rest()
    assert drive.ros.pose("turtlebot")[2] > yaw + 0.02
    assert not drive.screen.windows("Spawn Model")


def test_a_robot_stops_when_the_window_loses_the_keyboard_or_the_panel_is_closed(drive):
    with drive.held("Up"):
        drive.command()
        drive.screen.key("F1")
        drive.wait_for_dialog("Keys and Mouse")
        drive.wait_for_rest()
    drive.screen.key("Escape")
    drive.screen.wait_until_closed("Keys and Mouse")
    with drive.held("Up"):
        drive.command()
        drive.screen.key("F4")
        drive.wait_for_rest()
    drive.key("F4")
    drive.waiting(drive.find_knob, "the pad", 20)


def test_a_robot_is_driven_by_dragging_the_pad(drive):
    x, y = drive.find_knob()

    def while_held():
        forwards, turn = drive.command()
        assert forwards == pytest.approx(0.5)
        assert turn == pytest.approx(-0.5, abs=0.1)
        drive.screen.picture("window_pad")

    drive.screen.drag([(x, y), (x + 14, y - 30), (x + 28, y - 60)], while_held)
    drive.wait_for_rest()


def test_another_node_that_drives_the_same_robot_is_named(drive):
    other = drive.ros.start("rostopic", "pub", "-r", "5", "/cmd_vel", "geometry_msgs/Twist", "{}")
    amber = (253, 241, 207)

    def warns():
        pixels = drive.screen.picture("window_others")[:, 900:]
        return (abs(pixels - amber).max(axis=2) < 3).sum() > 500

    drive.waiting(warns, "the warning", 20)
    drive.ros.end(other)
    drive.waiting(lambda: not warns(), "the warning to go", 20)


BADGE = {"warning": (240, 196, 25), "error": (198, 40, 40)}


def badge_of(window, kind):
    """The middle of the badge in the status line; None if there is none of this colour."""
    line = window.screen.picture("window_badge")[740:, 300:1000]
    ys, xs = np.nonzero(abs(line - BADGE[kind]).max(axis=2) < 6)
    return (300 + xs.mean(), 740 + ys.mean()) if len(xs) > 300 else None


def open_problems(window, kind, name):
    """Opens the list by a click on the badge."""
    window.screen.click(window.waiting(lambda: badge_of(window, kind), "the badge", 30))
    window.wait_for_dialog("Problems")
    window.waiting(lambda: is_drawn(window, name), "the list", 20)


def clear_problems(window, kind):
    window.screen.key("alt+l", "Escape")
    window.screen.wait_until_closed("Problems")
    window.waiting(lambda: not badge_of(window, kind), "the badge to go", 20)


def test_warnings_of_the_server_are_counted_and_listed(window):
    for _ in range(2):
        window.ros.call("/delete_model", name="nothing")
    open_problems(window, "warning", "window_problems")
    clear_problems(window, "warning")


def test_robots_that_share_their_commands_are_a_problem(window):
    window.ros.spawn(ROBOT, "r2", 2.0, 1.0)
    open_problems(window, "warning", "window_shared")
    window.screen.key("Escape")
    window.screen.wait_until_closed("Problems")
    window.ros.call("/delete_model", name="r2")
    window.key("ctrl+r")


def test_errors_of_diagnostics_are_red(window):
    topic = ("/diagnostics", "diagnostic_msgs/DiagnosticArray")
    message = "{status: [{level: 2, name: 'arm: motor', message: 'too hot'}]}"
    program = window.ros.start("rostopic", "pub", "-r", "2", *topic, message)
    open_problems(window, "error", "window_errors")
    clear_problems(window, "error")
    window.ros.end(program)


def test_a_frame_of_two_nodes_is_a_problem(window):
    command = ("rosrun", "tf2_ros", "static_transform_publisher", *[0] * 6)
    programs = [
        window.ros.start(*command, parent, "shelf", f"__name:=tf_{parent}")
        for parent in ("map", "room")
    ]
    open_problems(window, "warning", "window_frames")
    window.screen.key("Escape")
    window.screen.wait_until_closed("Problems")
    for program in programs:
        window.ros.end(program)
    window.waiting(lambda: not badge_of(window, "warning"), "the badge to go", 30)


def has_hint(window):
    """Whether the status line shows a hint or message."""
    line = window.screen.picture("window_hint")[758:782, 10:400]
    return (line.max(axis=2) < 100).sum() > 40


def test_hints_go_when_they_no_longer_apply(window):
    window.press("a")
    window.wait_for_dialog("Spawn Model")
    window.waiting(lambda: has_hint(window), "the hint", 20)
    window.screen.key("Escape")
    window.screen.wait_until_closed("Spawn Model")
    window.waiting(lambda: not has_hint(window), "the hint to go", 20)
    window.press("space")
    window.waiting(lambda: has_hint(window), "the message", 20)
    window.press("space")
    window.waiting(lambda: not has_hint(window), "the message to go", 20)


def test_the_keys_are_shown(window):
    window.key("F1")
    window.wait_for_dialog("Keys and Mouse")

    def shows_text():
        middle = window.screen.picture("window_keys")[200:500, 340:940]
        return (middle.max(axis=2) < 60).sum() > 2000

    window.waiting(shows_text, "the keys", 20)
    window.screen.key("Escape")
    window.screen.wait_until_closed("Keys and Mouse")
