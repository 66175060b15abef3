"""Fields and panels of the window, without a screen."""

import pytest
from python_qt_binding.QtCore import QEvent, QLocale, QObject, Qt
from python_qt_binding.QtGui import QKeyEvent
from python_qt_binding.QtWidgets import QApplication

from flatland_viz.move_dialog import MoveDialog


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
