"""The displays of a world in the embedded rviz."""

from typing import Any, Dict, List, Set

from python_qt_binding.QtCore import QObject, QRectF, Signal
from python_qt_binding.QtGui import QColor

from flatland_viz.displays import COLORED, GOAL, PLAN, WALLS, Shown, changes, color_of

_LOOKS: Dict[str, Dict[str, Any]] = {
    PLAN: {"Line Style": "Billboards", "Line Width": 0.1, "Color": QColor("#009e73")},
    GOAL: {"Shaft Length": 0.6, "Shaft Radius": 0.08, "Head Length": 0.5, "Head Radius": 0.3},
}
"""Properties of rviz's own displays, by their classes."""


GRID = "rviz/Grid"


def displays_of(manager: Any, kind: str) -> List[Any]:
    """The displays of a class: none if the user has removed them."""
    root = manager.getRootDisplayGroup()
    displays = [root.getDisplayAt(index) for index in range(root.numDisplays())]
    return [display for display in displays if display.getClassId() == kind]


class WorldDisplays(QObject):
    """Adds and removes displays as the world changes, and applies colours and switches to them.

    Args:
        manager: rviz's.
    """

    walls_changed = Signal(QRectF)
    """The box around all walls [m]; null if there are none."""
    walls_progress = Signal(int)
    """Percent of the walls that are shown."""

    def __init__(self, manager: Any) -> None:
        super().__init__()
        self._manager = manager
        self._displays: Dict[Shown, Any] = {}
        self._markers: Dict[str, Any] = {}
        self._colors: Dict[str, str] = {}
        self._hidden_kinds: Set[str] = set()

    def show(self, wanted: List[Shown]) -> None:
        """Shows these displays alone; unchanged ones are not touched."""
        gone, new = changes(self._displays, wanted)
        for shown in gone:
            self._remove(self._displays.pop(shown))
        for shown in new:
            display = self._manager.createDisplay(shown.kind, shown.name, False)
            for name, value in _LOOKS.get(shown.kind, {}).items():
                display.subProp(name).setValue(value)
            display.subProp("Topic").setValue(shown.topic)
            self._displays[shown] = display
            if shown.kind == WALLS:
                self._follow_walls(display)
            self._apply_switches(shown)
            self._apply_color(shown)

    def show_markers(self, name: str, topic: str) -> None:
        """Shows the markers of a topic in a display of this name; an empty topic removes it."""
        if name in self._markers:
            self._remove(self._markers.pop(name))
        if topic:
            display = self._manager.createDisplay("rviz/Marker", name, True)
            display.subProp("Marker Topic").setValue(topic)
            self._markers[name] = display

    def show_kinds(self, on: bool, *kinds: str) -> None:
        """Shows or hides the displays of classes, or those with these names."""
        self._hidden_kinds = self._hidden_kinds - {*kinds} if on else self._hidden_kinds | {*kinds}
        for shown in self._displays:
            self._apply_switches(shown)

    def set_colors(self, colors: Dict[str, str]) -> None:
        """Sets the colours of scans, plans and goals: `#rrggbb` by topic or namespace."""
        self._colors = colors
        for shown in self._displays:
            self._apply_color(shown)

    def _remove(self, display: Any) -> None:
        display.setEnabled(False)
        self._manager.getRootDisplayGroup().takeDisplay(display).deleteLater()

    def _apply_switches(self, shown: Shown) -> None:
        is_wanted = shown.name not in self._hidden_kinds and shown.kind not in self._hidden_kinds
        if self._displays[shown].isEnabled() != is_wanted:
            self._displays[shown].setEnabled(is_wanted)

    def _apply_color(self, shown: Shown) -> None:
        color = color_of(shown.topic, self._colors) if shown.kind in COLORED else ""
        if color:
            self._displays[shown].subProp("Color").setValue(QColor(color))

    def _follow_walls(self, display: Any) -> None:
        """Follows the bounds and the progress that the walls' display reports.

        The properties are kept: only referenced by slots of their own, they would be garbage to
        Python, which would clear those slots while they are connected.
        """
        bounds, progress = display.subProp("Bounds"), display.subProp("Progress")
        self._walls_properties = (bounds, progress)
        bounds.changed.connect(lambda: self.walls_changed.emit(bounds.getValue()))
        progress.changed.connect(lambda: self.walls_progress.emit(progress.getValue()))
