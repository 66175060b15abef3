"""The window's menus and panels on a desktop with a window manager, by keys and mouse.

The server's topics and services have the results.
"""

import os
import signal
import time
import xmlrpc.client

import numpy as np
import pytest
from gui_screen import FIRST_ROBOT
from room_window import ROBOT, WORLD, WORLDS, RoomWindow
from screen_pictures import near

pytestmark = pytest.mark.slow

BOX = WORLDS / "office" / "box.model.yaml"
BOX_COLOR, ROBOT_COLOR = (194, 145, 87), (51, 128, 204)
SELECTED = (70, 76, 84)
TITLE = "Flatland.*"


def test_a_world_that_is_refused_opens_no_window(run, screen, tmp_path):
    world = tmp_path / "world.yaml"
    world.write_text("properties: {}\nlayers: []\nmodels: [{name: a, model: nowhere.model.yaml}]\n")
    launch = run(str(world), environment=screen.environment)
    seen = set()
    while launch.process.poll() is None:
        seen.update(screen.windows(TITLE))
        time.sleep(0.1)
    assert launch.process.returncode != 0
    assert "nowhere.model.yaml" in launch.output
    assert not seen


@pytest.fixture(scope="module")
def window(screen, ros, waiting, run_for_module, tmp_path_factory):
    return RoomWindow(screen, ros, waiting, run_for_module, tmp_path_factory.mktemp("worlds"))


@pytest.fixture
def paused(window):
    window.ros.call("/pause")
    window.wait_for_state(paused=True)
    yield window
    window.ros.call("/resume")
    window.wait_for_state(paused=False)
    window.waiting(lambda: not window.says("paused"), "the status line to say so")


def test_reset_starts_again(paused):
    paused.ros.spawn(BOX, "crate", 2.0, 1.0)
    paused.wait_for_models("turtlebot", "crate")
    before = paused.ros.state()["stamp"]
    paused.key("r")
    paused.wait_for_models("turtlebot")
    assert paused.ros.state()["stamp"] >= before > 0.0  # time goes on
    paused.screen.picture("window_reset")


def test_nothing_vanishes_in_a_reset(window):
    """Neither the robot nor its scan, also when time starts again and displays are cleared."""

    def pixels():
        picture = window.screen.picture("window_in_reset")
        view = picture[window.screen.view(picture)]
        return [near(view, color, 30).sum() for color in (ROBOT_COLOR, FIRST_ROBOT)]

    before = window.screen.settled(pixels, 0.5)
    assert min(before) > 100
    window.screen.picture("window_before_reset")
    reset = window.ros.start("rosservice", "call", "/reset", "{restart_time: true}")
    least, end = before, None
    while end is None or time.monotonic() < end:
        least = np.minimum(least, pixels())
        time.sleep(0.05)  # a frame lasts four times as long
        if end is None and reset.poll() is not None:
            end = time.monotonic() + 1.0  # the displays are cleared in this second
    assert (least > 0.7 * np.array(before)).all(), (before, least)


def test_single_steps_and_several(paused):
    before = paused.ros.state()["stamp"]
    paused.waiting(lambda: paused.says("paused"), '"paused" in the status line')
    message = lambda: paused.status_line("window_step")[0][:, : paused.screen.px(200)]  # noqa: E731
    for number in (1, 2):
        former = message()
        paused.key("F10")
        paused.wait_for_state(stamp=pytest.approx(before + 0.02 * number))
        paused.waiting(lambda m=former: (message() != m).any(), "a message with the new time")
    paused.key("shift+F10")
    paused.screen.wait_for_dialog("Steps")
    paused.screen.key("ctrl+a")
    paused.screen.type("20")
    paused.screen.picture("window_steps")
    paused.screen.key("Return")
    paused.wait_for_state(stamp=pytest.approx(before + 0.44))


def test_clicks_on_the_status_line_pause_and_change_the_rate(window):
    _, _, right, bottom = window.screen.inside(window.id)
    row = bottom - window.screen.px(13)
    state = (right - window.screen.px(100), row)
    for is_paused in (True, False):
        window.screen.click(state)
        window.wait_for_state(paused=is_paused)
        window.waiting(lambda p=is_paused: window.says("paused") == p, "the status line")
    for rate in ("0.5", "1"):
        window.screen.click((right - window.screen.px(200), row))
        window.screen.wait_for_dialog("Change Rate")
        window.screen.key("ctrl+a")
        window.screen.type(rate)
        window.screen.picture("window_rate")
        window.screen.key("Return")
        window.wait_for_state(rate=float(rate))
        window.screen.wait_until_closed("Change Rate")


def test_the_timeline_goes_back_and_the_run_goes_on_from_there(window):
    window.ros.call("/reset", restart_time=True, new_seed=False, seed=0)
    # The state is sent five times a second: the next message may be of before the reset.
    window.waiting(lambda: window.ros.state()["stamp"] < 2.0, "the beginning")
    window.waiting(lambda: window.ros.state()["stamp"] > 3.0, "three seconds")
    window.ros.call("/pause")
    window.waiting(lambda: window.says("paused"), "the window to know of them")
    window.ros.call("/resume")
    window.waiting(lambda: not window.says("paused"), "the run to go on")
    left, _, right, bottom = window.screen.inside(window.id)
    row = bottom - window.screen.px(27 + 14)  # above the status line

    window.screen.click((left + (right - left) // 3, row))
    window.wait_for_state(paused=True)
    past = window.ros.state()
    assert 0.3 < past["stamp"] < 0.7 * past["history_end"], past
    window.waiting(lambda: window.says("paused"), '"paused" in the status line')
    window.screen.picture("window_past")
    window.key("alt+End")
    window.wait_for_state(stamp=past["history_end"])
    window.key("alt+Left")
    window.wait_for_state(stamp=0.0)
    window.ros.call("/resume")
    window.waiting(lambda: 0.0 < window.ros.state()["history_end"] < 2.9, "the run to go on")


def test_files_are_reloaded_after_an_edit(window):
    crate = f"  - {{name: crate, pose: [2, 1, 0], model: {BOX}}}\n"
    window.world.write_text(WORLD + crate)
    window.key("F5")
    window.wait_for_models("turtlebot", "crate")

    window.world.write_text(WORLD + crate.replace("pose", "pos"))
    window.key("F5")
    window.screen.wait_for_dialog("Flatland")
    window.screen.picture("window_refused")
    window.screen.close("Flatland")
    assert window.ros.models() == ["turtlebot", "crate"]
    window.waiting(lambda: window.badge("warning"), "the badge")

    window.world.write_text(WORLD)
    window.key("F5")
    window.wait_for_models("turtlebot")
    window.waiting(lambda: not window.badge("warning"), "the badge to go with its cause")


def test_another_world_is_opened_and_the_first_one_again(window):
    other = WORLDS / "test_room" / "world.yaml"
    window.key("ctrl+o")
    dialog = window.screen.wait_for_dialog("Open a World")
    window.waiting(lambda: window.is_drawn(dialog, "window_open"), "the dialog to be drawn")
    window.screen.type(str(other))
    window.screen.picture("window_open")

    def is_closed():
        if window.screen.windows("Open a World"):
            window.screen.key("Return")  # or it takes a completion of the name, and closes that
        return not window.screen.windows("Open a World")

    window.waiting(is_closed, "the dialog to close")
    window.screen.wait_for_window("Flatland - test_room/world.yaml")
    topics = "/flatland_server/debug/topics"
    assert "layer/hall" in window.ros.message(topics, "flatland_msgs/DebugTopicList")["topics"]

    window.key("alt+w", "r")  # the menu of recent worlds
    window.screen.picture("window_recent")
    window.screen.key("Return")
    window.screen.wait_for_window("Flatland - room/world.yaml")


def test_a_spawn_that_was_refused_is_tried_again_at_its_place(window):
    window.choose_model(BOX, "turtlebot")
    window.screen.drag([window.map.pixel(x, 1.5) for x in (1.5, 2.0, 2.5)])
    window.screen.wait_for_dialog("Spawn Model")  # the name is taken
    window.screen.picture("window_taken")
    window.screen.type("crate")  # the name is selected
    window.screen.close("Spawn Model", "Return")
    window.wait_for_models("turtlebot", "crate")
    x, y, yaw = window.ros.pose("crate")
    window.screen.picture("window_spawned")
    assert (x, y) == pytest.approx((1.5, 1.5), abs=0.1)
    assert yaw == pytest.approx(0.0, abs=0.02)
    window.ros.call("/delete_model", name="crate")


@pytest.mark.parametrize("file", [ROBOT, ROBOT.name], ids=["path", "name"])
def test_a_second_robot_gets_a_name_and_a_namespace_of_its_own(window, file):
    (window.world.parent / ROBOT.name).write_text(ROBOT.read_text())
    window.press("a")
    window.screen.wait_for_dialog("Spawn Model")
    window.screen.key("alt+f", "ctrl+a")
    window.screen.type(file)
    window.screen.key("Tab")
    window.screen.picture("window_second")
    window.screen.close("Spawn Model", "Return")
    window.screen.click(window.map.pixel(1.5, 1.5))
    models = window.published_models("turtlebot", "turtlebot_2")
    assert [(model["name"], model["ns"]) for model in models] == [
        ("turtlebot", ""),
        ("turtlebot_2", "turtlebot_2"),
    ]
    window.ros.call("/delete_model", name="turtlebot_2")


def test_a_model_is_spawned_by_its_picture_and_a_drag(window):
    window.key("alt+w", "p")  # the same palette as by its button and its key
    dialog = window.screen.wait_for_dialog("Spawn Model")

    def picture():
        """The middle of the box's picture; it was spawned before."""
        left, top, _, _ = window.screen.frame(dialog)
        ys, xs = near(window.screen.picture_of(dialog, "window_palette"), BOX_COLOR, 20).nonzero()
        return (left + xs.mean(), top + ys.mean()) if len(xs) > 500 else None

    window.screen.click(window.waiting(picture, "the picture of the box"))
    window.screen.wait_until_closed("Spawn Model")

    def while_held():
        assert window.ros.models() == ["turtlebot"]

    window.screen.drag([window.map.pixel(2.0, y) for y in (-1.0, 0.0, 1.0)], while_held)
    window.wait_for_models("turtlebot", "box")
    x, y, yaw = window.ros.pose("box")
    assert (x, y, yaw) == (
        pytest.approx(2.0, abs=0.1),
        pytest.approx(-1.0, abs=0.1),
        pytest.approx(np.pi / 2, abs=0.05),
    )
    window.ros.call("/delete_model", name="box")


def test_escape_leaves_a_tool_from_anywhere(window):
    window.choose_model(BOX)
    window.key("ctrl+f")  # the search in the list of models has the keyboard
    window.screen.key("Escape")
    window.waiting(lambda: not window.has_hint(), "the hint to go")
    window.screen.click(window.map.pixel(1.5, 1.5))
    time.sleep(0.5)
    assert window.ros.models() == ["turtlebot"]


def test_a_copy_of_a_robot_without_a_namespace_has_one(window):
    window.screen.focus(window.id)
    window.screen.click(window.map.pixel(0.0, 0.0))
    window.screen.key("ctrl+d")
    models = window.published_models("turtlebot", "turtlebot_2")
    assert [model["ns"] for model in models] == ["", "turtlebot_2"]
    topics = [
        {topic["name"] for p in model["plugins"] for topic in p["topics"]} for model in models
    ]
    assert not topics[0] & topics[1]
    transforms = window.ros.message("/tf", "tf2_msgs/TFMessage")["transforms"]
    frames = [transform["child_frame_id"] for transform in transforms]
    assert len(set(frames)) == len(frames)
    assert {"base_link", "turtlebot_2_base_link"} <= set(frames)
    window.ros.call("/delete_model", name="turtlebot_2")


def is_marked(window):
    """True if the window's title shows that there are unsaved changes."""
    window.waiting(lambda: window.screen.windows(r"Flatland - room/world\.yaml\*?"), "the window")
    return bool(window.screen.windows(r"Flatland - room/world\.yaml\*"))


def test_edits_are_marked_undone_redone_and_saved(window):
    window.world.write_text(WORLD + "# mine\n")
    window.key("F5")
    window.choose_model(BOX, "crate")
    window.screen.drag([window.map.pixel(x, 1.5) for x in (1.5, 2.5)])
    window.wait_for_models("turtlebot", "crate")
    window.waiting(lambda: is_marked(window), "the mark")
    window.key("ctrl+z")
    window.wait_for_models("turtlebot")
    window.waiting(lambda: not is_marked(window), "no mark")
    window.key("ctrl+shift+z")
    window.wait_for_models("turtlebot", "crate")
    window.screen.drag([window.map.pixel(1.5, 1.5), window.map.pixel(1.0, 1.5)])
    window.waiting(lambda: abs(window.ros.pose("crate")[0] - 1.0) < 0.1, "the drag")
    window.screen.picture("window_unsaved")

    window.key("alt+F4")
    window.screen.wait_for_dialog("Flatland")
    window.screen.picture("window_question")
    window.screen.close("Flatland")
    window.key("ctrl+s")
    window.waiting(lambda: not is_marked(window), "the file to be saved")

    text = window.world.read_text()
    assert text.startswith(WORLD)
    assert text.endswith("# mine\n")
    assert "{name: crate, model: " in text
    window.key("F5")
    window.wait_for_models("turtlebot", "crate")
    assert window.ros.pose("crate")[0] == pytest.approx(1.0, abs=0.1)
    window.world.write_text(WORLD)
    window.key("F5")
    window.wait_for_models("turtlebot")


def lowest_text(window):
    """The lowest text in the panel of models, which is that of a topic."""
    _, top, right, bottom = window.screen.inside(window.id)
    bottom -= window.screen.px(60)  # the status line, and the timeline
    columns = slice(right - window.screen.px(240), right - window.screen.px(60))
    area = window.screen.picture("window_topics")[top:bottom, columns].astype(int)
    is_text = abs(area - np.median(area, axis=(0, 1))).max(axis=2) > 100
    return columns.start + window.screen.px(20), top + np.nonzero(is_text.any(axis=1))[0].max() - 3


def test_the_way_of_a_robot_is_drawn_and_its_topics_are_plotted(window):
    window.ros.call("/reset", restart_time=True)
    window.screen.focus(window.id)
    window.screen.click(window.map.pixel(0.0, 0.0))

    def line():
        """The pixels of its odometry's way, which covers its true one: it has no errors."""
        pixels = window.screen.picture("window_trail")
        return near(pixels[window.screen.view(pixels)], (230, 158, 0), 20).sum()

    before = line()
    window.key("t")
    driver = window.ros.start(
        "rostopic", "pub", "-r", "10", "/cmd_vel", "geometry_msgs/Twist", "{linear: {x: 0.3}}"
    )
    try:
        window.waiting(lambda: line() > before + 100, "the way")
        window.screen.move(lowest_text(window))
        window.screen.xdotool("click", "--repeat", 2, "--delay", 50, 1)
        plot = window.screen.wait_for_window("Plot: .*")

        def curve():
            return near(window.screen.picture_of(plot, "window_plot"), (0, 114, 178), 30).sum()

        window.waiting(lambda: curve() > 200, "a curve")
        window.screen.xdotool("windowclose", plot)
    finally:
        window.ros.end(driver)
    window.key("t")
    window.waiting(lambda: line() <= before + 20, "no way")
    assert "bad callback" not in window.launch.output


def test_an_error_of_the_window_is_logged_once_and_counted(window):
    window.ros.call("/reset", restart_time=True)
    window.screen.focus(window.id)
    topic = "{name: '', type: std_msgs/Empty, is_published: true}"
    models = f"{{models: [{{name: turtlebot, plugins: [{{topics: [{topic}]}}]}}]}}"
    text = "ValueError: topic name is not a non-empty string"
    other = window.ros.start(
        "rostopic", "pub", "-r", "50", "/flatland_server/models", "flatland_msgs/ModelList", models
    )
    try:
        clicked = -10.0

        def is_logged():
            """A click meets the robot once the reset is drawn; two at once are another thing."""
            nonlocal clicked
            if time.monotonic() > clicked + 2.0:
                window.screen.click(window.map.pixel(0.0, 0.0))
                clicked = time.monotonic()
            return text in window.launch.output

        window.waiting(is_logged, "the error")
        window.open_problems("error", "window_own_error")
        window.screen.close("Problems")
    finally:
        window.ros.end(other)
    window.ros.spawn(BOX, "crate", 2.0, 1.0)  # the server's own list again
    window.ros.call("/delete_model", name="crate")
    assert window.launch.output.count(text) == 1
    window.key("F5")
    window.waiting(lambda: not window.badge("error"), "the badge to go")


@pytest.fixture
def drive(window):
    """The window with the Drive panel, and the robot at rest."""
    window.ros.call("/reset", restart_time=True)
    window.key("F4")
    window.waiting(window.is_driving_panel_open, "the panel")
    yield window
    window.screen.xdotool("keyup", "Up", "keyup", "a")
    window.key("F4")
    window.waiting(lambda: not window.is_driving_panel_open(), "the panel to close")


def test_keys_drive_a_robot_until_they_are_released(drive):
    x, _, yaw = drive.ros.pose("turtlebot")
    with drive.held("Up"):
        assert drive.command() == (0.5, 0.0)
        drive.waiting(lambda: drive.ros.pose("turtlebot")[0] > x + 0.1, "the robot to move")
        pixels = drive.screen.picture("window_drive")
        panels = pixels[:, drive.screen.view(pixels)[1].stop :]
        # The list of models has the robot, by its dot, or its row if it is selected.
        assert near(panels, FIRST_ROBOT, 10).sum() > 20 or near(panels, SELECTED, 2).sum() > 1000
    drive.wait_for_rest()
    with drive.held("a"):  # elsewhere the key of Spawn Model
        assert drive.command() == (0.0, 1.0)
        drive.waiting(lambda: drive.ros.pose("turtlebot")[2] > yaw + 0.02, "the robot to turn")
    drive.wait_for_rest()
    assert not drive.screen.windows("Spawn Model")


def test_a_robot_stops_when_the_panel_loses_the_keyboard(drive):
    with drive.held("Up"):
        drive.command()
        drive.screen.key("F1")
        drive.screen.wait_for_dialog("Keys and Mouse")
        drive.wait_for_rest()
    drive.screen.close("Keys and Mouse")
    with drive.held("Up"):
        drive.command()
        drive.screen.key("F4")
        drive.wait_for_rest()
    drive.key("F4")
    drive.waiting(drive.is_driving_panel_open, "the panel")


def test_another_node_that_drives_the_same_robot_is_named(drive):
    other = drive.ros.start("rostopic", "pub", "-r", "5", "/cmd_vel", "geometry_msgs/Twist", "{}")
    amber = (253, 241, 207)

    def warns():
        return near(drive.screen.picture("window_others"), amber, 2).sum() > 500

    drive.waiting(warns, "the warning")
    drive.ros.end(other)
    drive.waiting(lambda: not warns(), "the warning to go")


def clear_problems(window, kind):
    window.screen.key("alt+l", "Escape")
    window.screen.wait_until_closed("Problems")
    window.waiting(lambda: not window.badge(kind), "the badge to go")


def test_warnings_of_the_server_are_counted_and_listed(window):
    for _ in range(2):
        window.ros.call("/delete_model", name="nothing")
    window.open_problems("warning", "window_problems")
    clear_problems(window, "warning")


def test_robots_that_share_their_commands_are_a_problem(window):
    window.ros.spawn(ROBOT, "r2", 2.0, 1.0)
    window.open_problems("warning", "window_shared")
    # tf2 has warned of the shared frames at each step.
    assert window.launch.output.count("redundant timestamp for frame base_link") == 1
    window.screen.close("Problems")
    window.ros.call("/delete_model", name="r2")
    window.key("r")


def test_errors_of_diagnostics_are_red(window):
    topic = ("/diagnostics", "diagnostic_msgs/DiagnosticArray")
    message = "{status: [{level: 2, name: 'arm: motor', message: 'too hot'}]}"
    program = window.ros.start("rostopic", "pub", "-r", "2", *topic, message)
    window.open_problems("error", "window_errors")
    window.screen.close("Problems")
    window.ros.end(program)
    window.waiting(lambda: not window.badge("error"), "the badge to go", 30)


def test_a_frame_of_two_nodes_is_a_problem(window):
    programs = [
        window.ros.publish_transform(parent, "shelf", f"__name:=tf_{parent}")
        for parent in ("map", "room")
    ]
    window.open_problems("warning", "window_frames")
    window.screen.close("Problems")
    for program in programs:
        window.ros.end(program)
    window.waiting(lambda: not window.badge("warning"), "the badge to go", 30)


def test_hints_go_when_they_no_longer_apply(window):
    window.press("a")
    window.screen.wait_for_dialog("Spawn Model")
    window.waiting(lambda: window.has_hint(), "the hint")
    window.screen.close("Spawn Model")
    window.waiting(lambda: not window.has_hint(), "the hint to go")
    window.press("space")
    window.waiting(lambda: window.has_hint(), "the message")
    window.press("space")
    window.waiting(lambda: not window.has_hint(), "the message to go")


def test_a_held_space_bar_pauses_once_and_other_keys_do_nothing(window):
    window.press("ctrl+a")  # it is no key of Spawn Model's, and opens no dialog
    with window.held("space"):
        window.wait_for_state(paused=True)
        topic = ("/flatland_server/state", "flatland_msgs/SimulationState")
        states = [state["paused"] for state in window.ros.messages(*topic, seconds=1.5)]
    assert len(states) > 4
    assert all(states)
    window.press("space")
    window.wait_for_state(paused=False)


def test_the_keys_are_shown(window):
    def shows_text():
        pixels = window.screen.picture_of(dialog, "window_keys").astype(int)
        return (abs(pixels - np.median(pixels)).max(axis=2) > 120).sum() > 2000

    view = lambda: window.screen.click(window.map.pixel(1.5, 1.5))  # noqa: E731
    search = lambda: window.screen.key("ctrl+f")  # noqa: E731
    for focus, keys in ((view, ["F1"]), *((each, ["alt+h", "k"]) for each in (view, view, search))):
        window.screen.focus(window.id)
        focus()
        window.screen.key(*keys)
        dialog = window.screen.wait_for_dialog("Keys and Mouse")
        window.waiting(shows_text, "the keys")
        window.screen.close("Keys and Mouse")


def pid_of(uri, node):
    """The process of a node."""
    place = xmlrpc.client.ServerProxy(uri).lookupNode("/test_gui_window", node)[2]
    return xmlrpc.client.ServerProxy(place).getPid("/test_gui_window")[2]


def test_after_a_crash_of_the_window_the_simulation_goes_on(window):
    launch = window.launch
    os.kill(pid_of(launch.uri, "/flatland_viz"), signal.SIGSEGV)

    launch.wait_for("process has died")
    [line] = [line for line in launch.output.splitlines() if "process has died" in line]
    assert "[flatland_viz-" in line
    assert "exit code -11" in line
    launch.wait_for("rosrun flatland_viz flatland_viz")
    window.screen.wait_until_closed(TITLE)
    before = window.ros.clock()
    window.waiting(lambda: window.ros.clock() > before + 0.2, "simulated time to go on")
    assert launch.process.poll() is None

    launch.press_ctrl_c()
    assert launch.process.wait(60) == 0
