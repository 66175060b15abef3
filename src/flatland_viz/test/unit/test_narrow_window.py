"""The toolbar and the status line where there is little room, without a screen."""

import pytest
from python_qt_binding.QtWidgets import QAction, QApplication, QLabel, QMainWindow

from flatland_viz.status import Simulation, status
from flatland_viz.status_line import StatusLine
from flatland_viz.toolbar import Toolbar, icon

NARROW = 250  # pixels: room for seven icons
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
    Tool("flatland_viz/ChangeRate", "Change Rate"),
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
    most_used = ["Interact", "Spawn Model", "Pause", "Step", "Reset", "Drive"]

    window.resize(1200, 300)
    application.processEvents()
    assert visible(bar) == [*most_used, "Change Rate", "Measure"]

    window.resize(NARROW, 300)
    application.processEvents()
    assert set(most_used) <= set(visible(bar))
    assert "Measure" not in visible(bar)

    goal = QAction("2D Nav Goal", bar)
    bar.insertAction(own, goal)
    window.resize(1200, 300)
    application.processEvents()
    assert visible(bar)[2] == "2D Nav Goal"


def test_buttons_do_not_move_when_pause_becomes_resume(window, application):
    bar = window.addToolBar("tools")
    for tool in TOOLS:
        bar.addAction(tool.getName()).setIcon(icon("resume"))
    Toolbar(bar, TOOLS)
    window.resize(1200, 300)
    application.processEvents()
    actions = {action.text(): action for action in bar.actions()}
    last = bar.widgetForAction(actions["Measure"])
    before = last.x()
    for name in ("Resume", "Pause"):
        actions["Pause"].setText(name)
        application.processEvents()
        assert last.x() == before


def test_a_speed_drops_words_instead_of_widening_the_window(window, application):
    line = StatusLine()
    window.setStatusBar(line)
    window.resize(1200, 300)
    line.show_status(status(Simulation(99999.0, False, 1.0, 1.0), 0.0))
    least = line.minimumSizeHint().width()
    line.show_status(status(Simulation(99999.0, False, 1000.0, 12.34), 0.0))
    assert line.minimumSizeHint().width() == least

    field = line.findChild(QLabel, "status_speed")
    texts = {}  # in the order in which they are shown
    for width in range(1200, least, -20):
        window.resize(width, 300)
        application.processEvents()
        texts[field.text()] = width
    assert list(texts) == ["12.34 x real time (asked: 1000 x)", "12.34 x real time", "12.34 x"]
