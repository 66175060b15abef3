"""Fields and panels of the window, without a screen."""

import gc
import math
import threading
import time
import weakref
from pathlib import Path
from types import SimpleNamespace

import pytest
from python_qt_binding.QtCore import QEvent, QLocale, QObject, QPoint, Qt, QTimer
from python_qt_binding.QtGui import QColor, QKeyEvent, QPalette
from python_qt_binding.QtTest import QTest
from python_qt_binding.QtWidgets import (
    QApplication,
    QFileDialog,
    QLabel,
    QLineEdit,
    QListWidget,
    QMainWindow,
    QMessageBox,
    QSlider,
    QToolButton,
    QTreeWidget,
    QWidget,
)
from waiting import wait_until

from flatland_viz import drive_panel, model_panel, world_menu
from flatland_viz.drive_panel import NumberField
from flatland_viz.file_dialog import ask_for_file
from flatland_viz.garbage import collect_on_this_thread
from flatland_viz.labels import SelectableLabel
from flatland_viz.model_actions import ModelActions, pose_in, text_of
from flatland_viz.model_list import Model, Topic
from flatland_viz.problem_badge import ProblemList
from flatland_viz.problems import Problem
from flatland_viz.selection import Selection
from flatland_viz.simulation_menu import rate_of
from flatland_viz.status import Simulation, Status
from flatland_viz.status_line import StatusLine
from flatland_viz.theme import Theme
from flatland_viz.timeline import Timeline
from flatland_viz.world_menu import WorldMenu


@pytest.fixture(scope="module")
def application():
    """Qt's application, with garbage collection as in the window."""
    application = QApplication.instance() or QApplication(["test", "-platform", "offscreen"])
    collection = collect_on_this_thread()
    yield application
    collection.stop()
    gc.collect()
    gc.enable()


@pytest.fixture(params=["en_US", "de_DE"])
def locale(request):
    before = QLocale()
    QLocale.setDefault(QLocale(request.param))
    yield
    QLocale.setDefault(before)


def send_key(receiver, kind, key, text=""):
    QApplication.sendEvent(receiver, QKeyEvent(kind, key, Qt.NoModifier, text))


@pytest.mark.parametrize("text", ["1.5", "1,5"])
def test_decimal_point_and_comma_are_equal_in_every_locale(application, locale, text):
    field = NumberField("speed")
    field.setRange(0.0, 20.0)
    field.selectAll()
    for character in text:
        send_key(field, QEvent.KeyPress, 0, character)
    assert field.value() == rate_of(text) == 1.5


def test_a_pose_is_read_as_it_is_written_in_world_files():
    assert pose_in(" 1 2 3 ") == (1.0, 2.0, 3.0)
    pose = (-1.5, 2.0, 0.25)
    assert pose_in("[-1.5, 2, 0.25]") == pose_in(text_of(pose)) == pose
    assert [pose_in(text) for text in ("1, 2", "1, 2, x", "1, 2, inf", "")] == [None] * 4


def test_a_rate_is_a_number_or_unlimited():
    assert rate_of("as fast as possible") == math.inf
    assert rate_of(" 0.5") == 0.5
    assert math.isnan(rate_of("fast"))  # the server refuses it


def test_times_of_problems_are_simulated_or_of_the_day(application, monkeypatch):
    monkeypatch.setenv("TZ", "UTC")
    time.tzset()
    problems = ProblemList(None)
    problems.show_problems(
        [Problem("/server", "text", False, 1, at) for at in (0.0, 12.34, 1_800_000_000.7)]
    )
    monkeypatch.undo()
    time.tzset()

    tree = problems.findChild(QTreeWidget)
    times = [tree.topLevelItem(row).text(0) for row in range(3)]
    assert times == ["", "12.3 s", "08:00:00"]


def moment(time, begin, end):
    return Simulation(time, True, 1.0, 1.0, begin, end)


def test_the_timeline_seeks_when_the_button_is_released(application):
    timeline, sought = Timeline(), []
    timeline.sought.connect(sought.append)
    timeline.resize(600, 30)
    timeline.show()
    slider, label = timeline.findChild(QSlider), timeline.findChild(QLabel, "timeline_time")
    assert not slider.isEnabled()
    timeline.show_simulation(moment(50.0, 10.0, 50.0))
    middle = QPoint(slider.width() // 2, slider.height() // 2)

    QTest.mousePress(slider, Qt.LeftButton, Qt.NoModifier, middle)
    timeline.show_simulation(moment(51.0, 10.0, 51.0))  # does not move the knob that is held
    assert (sought, label.text()) == ([], "30.0 of 50.0 s")
    QTest.mouseRelease(slider, Qt.LeftButton, Qt.NoModifier, middle)

    assert sought == [pytest.approx(30.0, abs=0.3)]
    timeline.show_simulation(moment(30.0, 10.0, 51.0))
    assert label.text() == "30.0 of 51.0 s"
    timeline.show_simulation(moment(51.0, 10.0, 51.0))
    assert (slider.value(), label.text()) == (slider.maximum(), "")
    timeline.show_simulation(moment(51.0, 51.0, 51.0))
    assert not slider.isEnabled()


class Publisher:
    """Records commands by topic."""

    def __init__(self):
        self.topic, self.velocity = "", (0.0, 0.0, 0.0)
        self.commands = {}

    def open(self, topic):
        self.topic = topic

    def command(self, velocity):
        self.velocity = self.commands[self.topic] = velocity


SETTINGS = SimpleNamespace(number=lambda key, default: default, set_number=lambda key, value: None)
"""Settings without stored values."""


def robot(name):
    topic = Topic(f"/{name}/cmd_vel", "geometry_msgs/Twist", False, "drive")
    return Model(name, name, "", ("drive (DiffDrive)",), (), (topic,), 0.4, False)


@pytest.fixture
def drive(application, monkeypatch):
    """The Drive panel in a window, with two robots."""
    monkeypatch.setattr(drive_panel, "DrivePublisher", Publisher)
    window = QMainWindow()
    panel = drive_panel.DrivePanel(Selection(), SETTINGS)
    window.addDockWidget(Qt.RightDockWidgetArea, panel)
    window.show()
    panel.start()
    panel.set_models({"r1": robot("r1"), "r2": robot("r2")})
    yield panel
    window.close()


def test_keys_that_are_held_together_drive(drive):
    handle, commands = drive.window().windowHandle(), drive._publisher.commands
    drive._speed.setValue(2.0)
    for key in (Qt.Key_W, Qt.Key_Left, Qt.Key_E):
        send_key(handle, QEvent.KeyPress, key)
    assert commands["/r1/cmd_vel"] == (2.0, -2.0, 1.0)
    send_key(handle, QEvent.KeyPress, Qt.Key_Shift)
    assert commands["/r1/cmd_vel"] == (1.0, -1.0, 0.5)
    for key in (Qt.Key_W, Qt.Key_Left, Qt.Key_E):
        send_key(handle, QEvent.KeyRelease, key)
    assert commands["/r1/cmd_vel"] == (0.0, 0.0, 0.0)


def test_deleting_a_robot_does_not_pass_a_held_key_to_the_next(drive):
    send_key(drive.window().windowHandle(), QEvent.KeyPress, Qt.Key_Up)
    commands = drive._publisher.commands
    assert commands["/r1/cmd_vel"] == (0.5, 0.0, 0.0)

    drive.set_models({"r2": robot("r2")})
    assert commands["/r1/cmd_vel"] == (0.0, 0.0, 0.0)
    assert commands["/r2/cmd_vel"] == (0.0, 0.0, 0.0)


@pytest.fixture
def actions(application):
    """The actions of a selected model, in a window with the keyboard focus.

    The model rests, with a negative zero in its pose.
    """
    window = QMainWindow()
    selection = Selection()
    actions = ModelActions(window, None, selection, None)
    actions.set_models({"r1": robot("r1")})
    selection.select("r1")
    selection.set_state({"name": "r1", "x": 1.5, "y": -0.0, "theta": -0.00001})
    window.show()
    window.activateWindow()
    QTest.qWaitForWindowActive(window)
    yield actions
    window.close()


def test_a_copy_has_a_frame_of_odometry_of_its_own(actions):
    namespaces = []

    def spawn(file, name, namespace, pose, then):
        namespaces.append(namespace)
        then()

    actions._services = SimpleNamespace(spawn=spawn)
    actions.set_models({"r1": robot("r1")._replace(file="robot.yaml")})
    actions.duplicate.trigger()

    assert namespaces == ["~r2"]
    assert actions.has_edited


def test_the_menu_names_the_next_edit_to_undo(actions):
    actions.show_simulation(Simulation(0.0, False, 1.0, 1.0, undo="Move r1"))

    found = [(action.text(), action.isEnabled()) for action in (actions.undo, actions.redo)]
    assert found == [("&Undo: Move r1", True), ("&Redo", False)]


def test_a_copied_pose_has_no_negative_zeros(actions):
    actions.copy_pose.trigger()
    assert QApplication.clipboard().text() == "[1.500, 0.000, 0.0000]"


def test_selected_text_is_copied_instead_of_the_pose(actions):
    window = actions.parent()
    label = SelectableLabel(text="diff_drive (DiffDrive)")
    window.setCentralWidget(label)
    label.setFocus()
    QTest.keyClick(label, Qt.Key_C, Qt.ControlModifier)
    assert QApplication.clipboard().text().startswith("[")
    label.setSelection(0, 10)
    QTest.keyClick(label, Qt.Key_C, Qt.ControlModifier)
    assert QApplication.clipboard().text() == "diff_drive"


MONITOR = SimpleNamespace(watch=lambda topics: None, readings=lambda time: {})
"""A monitor of topics without messages."""


def test_a_long_name_does_not_push_buttons_out_of_the_panel(actions, application, monkeypatch):
    monkeypatch.setattr(model_panel, "TopicMonitor", lambda: MONITOR)
    selection, window = Selection(), actions.parent()
    panel = model_panel.ModelPanel(selection, actions)
    window.addDockWidget(Qt.RightDockWidgetArea, panel)
    names = [f"delivery_robot_of_the_second_floor_in_the_east_wing_{i}" for i in range(2)]
    panel.set_models({name: robot(name) for name in names})
    selection.select(names[1])
    application.processEvents()
    title = panel.findChild(QLabel, "model_name")
    assert title.toolTip() == names[1]
    assert title.text().startswith("delivery")
    assert title.text().endswith("_1")
    for button in panel.findChildren(QToolButton):
        assert button.mapTo(panel, button.rect().bottomRight()).x() < panel.width()


def test_a_held_key_does_not_repeat_actions_on_models(actions):
    assert not any(action.autoRepeat() for action in (*actions.all, actions.undo))


def test_the_dialog_for_a_new_file_adds_the_suffix(application, tmp_path):
    def choose():
        [dialog] = [w for w in QApplication.topLevelWidgets() if isinstance(w, QFileDialog)]
        dialog.selectFile(str(tmp_path / "floor"))
        dialog.accept()

    QTimer.singleShot(0, choose)
    file = ask_for_file(None, "Save", str(tmp_path / "a.png"), "PNG (*.png)", is_new=True)
    assert file == str(tmp_path / "floor.png")


def luminance(color):
    """Relative luminance, as in WCAG 2."""
    parts = (color.redF(), color.greenF(), color.blueF())
    linear = [p / 12.92 if p <= 0.03928 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


@pytest.mark.parametrize("background", ["#efefef", "#2d2d30"])
def test_the_state_is_readable_on_light_and_dark_desktops(application, background):
    line = StatusLine()
    palette = line.palette()
    palette.setColor(QPalette.Window, QColor(background))
    line.setPalette(palette)
    line.show_status(Status("1.0 s", "", "running"))
    text = QColor(line.findChild(QLabel, "status_state").styleSheet().split()[-1])
    low, high = sorted((luminance(text), luminance(QColor(background))))
    assert (high + 0.05) / (low + 0.05) >= 4.0


def test_clicks_on_the_status_line_pause_and_open_the_rate(application):
    line, asked = StatusLine(), []
    line.pause_asked.connect(lambda: asked.append("pause"))
    line.rate_asked.connect(lambda: asked.append("rate"))
    state, speed = line.findChild(QLabel, "status_state"), line.findChild(QLabel, "status_speed")
    for shown in ("running", "paused", "no server"):
        line.show_status(Status("1.0 s", "", shown))
        QTest.mouseClick(state, Qt.LeftButton)
    QTest.mouseClick(speed, Qt.LeftButton)
    assert asked == ["pause", "pause", "rate"]


def test_a_hint_that_does_not_fit_is_elided(application):
    line = StatusLine()
    line.show()
    hint = line.findChild(QLabel, "status_hint")
    for width, ends in ((1500, "all."), (700, "\u2026")):
        line.resize(width, 30)
        line.show_hint(f"<b>Drag:</b> Move the map. <b>Home:</b> Show it {'all ' * 20}all.")
        application.processEvents()
        assert hint.text().endswith(ends), hint.text()
    assert hint.toolTip().startswith("Drag: Move the map.")
    assert "<b>" not in hint.text()


def test_the_status_line_shows_what_the_view_follows(actions, application):
    line = StatusLine()
    line.show()
    actions.followed.connect(line.show_followed)
    line.following_ended.connect(actions.end_following)
    actions._follow_model = lambda name: None
    button = line.findChild(QToolButton, "status_followed")
    assert not button.isVisible()
    actions.follow.trigger()
    assert button.isVisible()
    assert "r1" in button.text()
    button.click()
    assert not button.isVisible()
    assert not actions.follow.isChecked()


def test_the_list_of_models_is_searched(actions, application, monkeypatch):
    monkeypatch.setattr(model_panel, "TopicMonitor", lambda: MONITOR)
    selection = Selection()
    panel = model_panel.ModelPanel(selection, actions)
    panel.set_models({name: robot(name) for name in ("r1", "crate_1", "Crate_2")})
    search, models = panel.findChild(QLineEdit), panel.findChild(QListWidget)

    def shown():
        return [
            models.item(row).text() for row in range(models.count()) if not models.isRowHidden(row)
        ]

    QTest.keyClicks(search, "crate")
    assert shown() == ["crate_1", "Crate_2"]
    panel.set_models({name: robot(name) for name in ("r1", "crate_1", "Crate_3")})
    assert shown() == ["crate_1", "Crate_3"]
    QTest.keyClick(search, Qt.Key_Return)
    assert selection.name == "crate_1"
    search.clear()
    assert len(shown()) == 3


def test_the_dark_look_is_readable_and_the_light_one_comes_back(application):
    theme, label = Theme(), QLabel("Pose")
    before = label.palette().color(QPalette.WindowText)
    theme.apply("dark")
    palette = application.palette()
    for text, behind in (
        (QPalette.Text, QPalette.Base),
        (QPalette.WindowText, QPalette.Window),
        (QPalette.ButtonText, QPalette.Button),
        (QPalette.HighlightedText, QPalette.Highlight),
    ):
        low, high = sorted(luminance(palette.color(role)) for role in (text, behind))
        assert (high + 0.05) / (low + 0.05) >= 4.5
    seen = []

    def change():  # Qt changes widgets only while it runs
        for look in ("light", "dark", "light"):
            theme.apply(look)
            seen.append(label.palette().color(QPalette.WindowText))
        application.quit()

    QTimer.singleShot(0, change)
    application.exec_()
    assert [color.lightness() > 128 for color in seen] == [False, True, False]
    assert seen[-1] == before


def test_widgets_are_collected_on_the_thread_of_the_window_alone(application):
    threads = []  # on which they are collected
    for _ in range(50):
        widget = QWidget()
        widget.itself = widget
        weakref.finalize(widget, lambda: threads.append(threading.get_ident()))
    del widget
    other = threading.Thread(target=lambda: [[] for _ in range(100_000)])
    other.start()
    other.join()
    theme = Theme()
    for look in ("dark", "light"):
        theme.apply(look)
    assert threads == []

    kept = [[] for _ in range(1000)]
    wait_until(lambda: application.processEvents() or len(threads) == 50, "the widgets to go")
    assert set(threads) == {threading.get_ident()}
    assert kept


class World(QObject):
    """Notes what is done; saves at once."""

    def __init__(self):
        super().__init__()
        self.has_edited, self.saved, self.resets = False, [], 0

    def save(self, path, then):
        self.saved.append(path)
        then()

    def open(self, path):
        pass

    def reload(self):
        pass

    def reset(self):
        self.resets += 1


class Worlds:
    """Settings with a list of worlds."""

    def __init__(self):
        self.worlds = []

    def list(self, key):
        return self.worlds

    def set_list(self, key, worlds):
        self.worlds = worlds


@pytest.fixture
def saving(application):
    window, world = QMainWindow(), World()
    menu = WorldMenu(window, world, world, Worlds())
    window.menuBar().addMenu(menu)
    return menu, window, world


def with_edits(number):
    return Simulation(1.0, False, 1.0, 1.0, edits=number)


def test_changes_by_programs_are_no_unsaved_changes_of_the_user(saving):
    menu, window, world = saving
    menu.show_simulation(with_edits(2))  # robots that a launch file has spawned
    assert not window.isWindowModified()
    assert not menu.keep_changes("closing", window.close)
    assert menu._save_action.isEnabled()

    world.has_edited = True
    menu.show_simulation(with_edits(3))
    assert window.isWindowModified()
    menu._save_action.trigger()
    menu.show_simulation(with_edits(1))
    assert not window.isWindowModified()


def test_a_reset_asks_before_changes_are_lost(saving):
    menu, window, world = saving
    menu.show_simulation(with_edits(0))
    menu.reset.trigger()
    assert world.resets == 1

    world.has_edited = True
    menu.show_simulation(with_edits(1))
    menu.reset.trigger()
    assert world.resets == 1
    [question] = window.findChildren(QMessageBox)
    question.button(QMessageBox.Discard).click()
    assert world.resets == 2


def test_worlds_that_were_opened_come_first_and_each_once(saving):
    menu, _, _ = saving
    for path in ("/a", "/b", "/a"):
        menu.set_world(path)
    assert menu._settings.worlds == ["/a", "/b"]
    for number in range(9):
        menu.set_world(f"/{number}")
    assert menu._settings.worlds == [f"/{number}" for number in reversed(range(1, 9))]


def test_a_world_of_the_installation_is_saved_in_a_copy(saving, tmp_path, monkeypatch):
    menu, _, world = saving
    menu.show_simulation(with_edits(1))
    package, answers = tmp_path / "share" / "my_robots", ["", "/home/me/floor.yaml"]
    package.mkdir(parents=True)
    (package / "package.xml").write_text("<package/>")
    asked = []

    def ask(parent, title, start, kinds, is_new):
        asked.append(start)
        return answers.pop(0)

    monkeypatch.setattr(world_menu, "ask_for_file", ask)
    for path in (package / "floor.yaml", tmp_path / "world.yaml"):
        path.touch()
        menu.set_world(str(path))
        menu._save_action.trigger()
        menu._save_action.trigger()

    assert asked == [str(Path.home() / "floor.yaml")] * 2
    assert world.saved == ["/home/me/floor.yaml", "", ""]  # none where the dialog was cancelled
