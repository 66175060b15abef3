"""Actions of menus, each with its key and its tooltip."""

from typing import Callable

from python_qt_binding.QtGui import QKeySequence
from python_qt_binding.QtWidgets import QAction, QWidget


def add_action(
    place: QWidget, text: str, do: Callable[[], object], key: str = "", tip: str = ""
) -> QAction:
    """Adds an action to a menu, or to a window in which its key then holds.

    Args:
        place: the menu or window.
        text: its name. A key after a tab belongs to a tool of rviz, and is only shown.
        do: called each time, but once while the key is held.
        key: such as "Ctrl+S".
        tip: of its entry and of a button.
    """
    action = QAction(text, place)
    action.triggered.connect(lambda checked: do())
    action.setAutoRepeat(False)
    if key:
        action.setShortcut(QKeySequence(key))
    name = tip or text.partition("\t")[0].replace("&", "").rstrip(".")
    action.setToolTip(f"{name} ({key})" if key else name)
    place.addAction(action)
    return action


def add_switch(
    place: QWidget, text: str, name: str, switch: Callable[[bool], object], key: str = ""
) -> QAction:
    """Adds a checkable action that is on at first.

    Args:
        place: the menu.
        text: its name.
        name: by which settings remember it.
        switch: called with each change.
        key: such as "N".
    """
    action = add_action(place, text, lambda: None, key)
    action.setObjectName(f"action_show_{name}")
    action.setCheckable(True)
    action.setChecked(True)
    action.toggled.connect(switch)
    return action
