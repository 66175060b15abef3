"""Switches of the view: what is shown of models and of navigation."""

from typing import Any, Callable, Dict

from python_qt_binding.QtCore import QObject
from python_qt_binding.QtWidgets import QAction, QMenu

_SWITCHES = {
    "labels": "&Names",
    "headings": "H&eadings",
    "handles": "&Handles",
    "scans": "&Scans",
    "plans": "&Plans and goals",
    "footprints": "&Footprints",
}


class ViewSwitches(QObject):
    """Checkable actions in a menu.

    Args:
        menu: menu that gets the actions, before its first separator.
        switches: the function of each, by the names of `_SWITCHES`.
    """

    def __init__(self, menu: QMenu, switches: Dict[str, Callable[[bool], Any]]) -> None:
        super().__init__(menu)
        first = menu.actions()[0]
        for name, text in _SWITCHES.items():
            action = QAction(text, self, objectName=f"action_show_{name}")
            action.setCheckable(True)
            action.setChecked(True)
            action.toggled.connect(switches[name])
            menu.insertAction(first, action)
        menu.insertSeparator(first)
