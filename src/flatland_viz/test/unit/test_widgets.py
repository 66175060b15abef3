"""Fields and panels of the window, without a screen."""

import pytest
from python_qt_binding.QtCore import QEvent, QLocale, QObject, Qt, Signal
from python_qt_binding.QtGui import QKeyEvent
from python_qt_binding.QtWidgets import QApplication, QMainWindow

from flatland_viz import drive_panel
from flatland_viz.model_list import Model, Topic
from flatland_viz.move_dialog import MoveDialog
from flatland_viz.selection import Selection


@pytest.fixture(scope="module")
def application():
    return QApplication.instance() or QApplication(["test", "-platform", "offscreen"])


@pytest.fixture(params=["en_US", "de_DE"])
def locale(request):
    before = QLocale()
    QLocale.setDefault(QLocale(request.param))
    yield
    QLocale.setDefault(before)


def send_key(receiver, kind, key, text=""):
    QApplication.sendEvent(receiver, QKeyEvent(kind, key, Qt.NoModifier, text))


@pytest.mark.parametrize("text", ["-1.5", "-1,5"])
def test_a_decimal_point_and_a_comma_mean_the_same_in_every_locale(application, locale, text):
    dialog = MoveDialog(None, "crate", (1234.5, 0.0, 0.0))
    field = dialog.findChild(QObject, "x")
    assert field.text() == "1234.500 m"
    field.selectAll()
    for character in text:
        send_key(field, QEvent.KeyPress, 0, character)
    assert dialog.pose == (-1.5, 0.0, 0.0)


class Publisher:
    """Records commands by topic."""

    def __init__(self):
        self.topic, self.velocity = "", (0.0, 0.0, 0.0)
        self.commands = {}

    def open(self, topic):
        self.topic = topic

    def command(self, velocity):
        self.velocity = self.commands[self.topic] = velocity


class Watch(QObject):
    changed = Signal(str, object)

    def watch(self, topic):
        pass


class Settings:
    """Without values."""

    def number(self, key, default):
        return default


def robot(name):
    topic = Topic(f"/{name}/cmd_vel", "geometry_msgs/Twist", False, "drive")
    return Model(name, name, "", ("drive (DiffDrive)",), (), (topic,), 0.4)


def test_a_held_key_does_not_drive_the_next_robot_when_its_own_is_deleted(application, monkeypatch):
    monkeypatch.setattr(drive_panel, "DrivePublisher", Publisher)
    monkeypatch.setattr(drive_panel, "PublisherWatch", Watch)
    window = QMainWindow()
    panel = drive_panel.DrivePanel(Selection(), Settings())
    window.addDockWidget(Qt.RightDockWidgetArea, panel)
    window.show()
    panel.start()
    panel.set_models({"r1": robot("r1"), "r2": robot("r2")})
    send_key(window.windowHandle(), QEvent.KeyPress, Qt.Key_Up)
    commands = panel._publisher.commands
    assert commands["/r1/cmd_vel"] == (0.5, 0.0, 0.0)

    panel.set_models({"r2": robot("r2")})
    assert commands["/r1/cmd_vel"] == (0.0, 0.0, 0.0)
    assert commands["/r2/cmd_vel"] == (0.0, 0.0, 0.0)
    window.close()
