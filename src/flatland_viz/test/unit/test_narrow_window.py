"""The toolbar and the status line where there is little room, without a screen."""

import pytest
from python_qt_binding.QtWidgets import QAction, QApplication, QLabel, QMainWindow

from flatland_viz.status import Simulation, status
from flatland_viz.status_line import StatusLine
from flatland_viz.toolbar import Toolbar, icon

NARROW = 450  # pixels
ICONS = ("step", "reset", "drive")


class Tool:
    """A tool of rviz."""

    def __init__(self, kind, name):
        self.getClassId = lambda: kind
        self.getName = lambda: name
        self.getShortcutKey = lambda: name[0]
        self.getDescription = lambda: f"the tool {name}"


TOOLS = [
    Tool("flatland_viz/Interact", "Interact"),
    Tool("flatland_viz/Measure", "Measure"),
    Tool("flatland_viz/SpawnModel", "Spawn Model"),
    Tool("flatland_viz/PauseSim", "Pause"),
]


@pytest.fixture(scope="module")
def application():
    return QApplication(["test", "-platform", "offscreen"])


@pytest.fixture
def window(application):
    window = QMainWindow()
    window.show()
    yield window
    window.close()


def visible(bar):
    """The names of the visible buttons, from the left."""
    buttons = [(action, bar.widgetForAction(action)) for action in bar.actions()]
    seen = [(button.x(), action.text()) for action, button in buttons if button.isVisible()]
    return [name for _, name in sorted(seen) if name]


def test_the_least_used_buttons_vanish_first(window, application):
    bar = window.addToolBar("tools")
    for tool in TOOLS:
        action = bar.addAction(tool.getName())
        action.setIcon(icon("resume"))
    own = bar.addSeparator()  # of rviz, which adds tools before it
    own.setVisible(False)
    toolbar = Toolbar(bar, TOOLS)
    for name in ICONS:
        toolbar.add(QAction(name.capitalize(), bar), name, name.capitalize())
    order = ["Interact", "Spawn Model", "Pause", "Step", "Reset", "Drive", "Measure"]

    window.resize(1200, 300)
    application.processEvents()
    assert visible(bar) == order

    window.resize(NARROW, 300)
    application.processEvents()
    seen = visible(bar)
    assert 2 < len(seen) < len(order)
    assert seen == order[: len(seen)]

    goal = QAction("2D Nav Goal", bar)
    bar.insertAction(own, goal)
    window.resize(1200, 300)
    application.processEvents()
    assert visible(bar)[2] == "2D Nav Goal"


def test_a_high_speed_does_not_widen_the_window(window):
    line = StatusLine()
    window.setStatusBar(line)
    window.resize(1200, 300)
    widths = []
    for rate, factor in ((1.0, 1.0), (10.0, 8.34)):
        line.show_status(status(Simulation(99999.0, False, rate, factor), 0.0))
        widths.append(line.findChild(QLabel, "status_speed").sizeHint().width())
    assert widths[0] == widths[1]
