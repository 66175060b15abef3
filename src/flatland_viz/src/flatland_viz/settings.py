"""Settings that the window keeps between starts, in ~/.config/flatland/window.conf."""

from typing import Any, List, Optional

from python_qt_binding.QtCore import QByteArray, QSettings
from python_qt_binding.QtWidgets import QAction, QMainWindow, QMenu

_SWITCHES = "switches"
DARK = "action_background_dark"
"""The switch for the dark look."""
_LAYOUT = 2
"""Version of saved panels. Those of version 0 may lack the toolbar and panels, as they were saved
after the window had closed; those of version 1 have Models behind Drive."""


class Settings:
    """Named values in a file of the user's. A file that cannot be written is ignored."""

    def __init__(self) -> None:
        self._store = QSettings("flatland", "window")
        self._first_layout: List[QByteArray] = []

    def number(self, key: str, default: float) -> float:
        """A number; `default` if there is none."""
        try:
            return float(self._store.value(key, default))
        except (TypeError, ValueError):
            return default

    def set_number(self, key: str, value: float) -> None:
        """Remembers a number."""
        self._store.setValue(key, value)

    def list(self, key: str) -> List[str]:
        """A list of strings; empty if there is none."""
        value: Any = self._store.value(key, [])
        return [value] if isinstance(value, str) else [str(each) for each in value or []]

    def set_list(self, key: str, value: List[str]) -> None:
        """Remembers a list of strings."""
        self._store.setValue(key, value)

    def is_on(self, switch: str) -> bool:
        """True if an action with this object name was checked last."""
        return str(self._store.value(f"{_SWITCHES}/{switch}")) == "true"

    def follow_switches(self, menu: QMenu) -> None:
        """Restores the checked actions of a menu and its submenus, and remembers changes.

        Each must have an object name. To be called when their signals are connected.
        """
        for action in menu.actions():
            if action.menu() is not None:
                self.follow_switches(action.menu())
            elif action.isCheckable() and action.objectName():
                self._follow(action)

    def _follow(self, action: QAction) -> None:
        key = f"{_SWITCHES}/{action.objectName()}"
        before = self._store.value(key)
        is_on = str(before) == "true"
        # In an exclusive group, only another action switches one off.
        can_change = is_on or action.actionGroup() is None
        if before is not None and is_on != action.isChecked() and can_change:
            action.trigger()
        action.toggled.connect(lambda is_on: self._store.setValue(key, is_on))

    def restore_window(self, window: QMainWindow, inner: QMainWindow) -> bool:
        """Gives the window its former place, size and panels. Returns whether it had any.

        Qt keeps it within the screen. Its panels now are those of `reset_layout`.

        Args:
            window: window to restore.
            inner: the one within it, which has panels of its own.
        """
        self._first_layout = [each.saveState(_LAYOUT) for each in (window, inner)]
        geometry = _bytes(self._store.value("geometry"))
        for key, each in (("panels", window), ("inner_panels", inner)):
            panels = _bytes(self._store.value(key))
            if panels is not None:
                each.restoreState(panels, _LAYOUT)
        return geometry is not None and bool(window.restoreGeometry(geometry))

    def reset_layout(self, window: QMainWindow, inner: QMainWindow) -> None:
        """Gives the window the panels and toolbars of its first start."""
        for layout, each in zip(self._first_layout, (window, inner)):
            each.restoreState(layout, _LAYOUT)

    def save_window(self, window: QMainWindow, inner: QMainWindow) -> None:
        """Saves the window's place, size and panels for `restore_window`.

        To be called while it is shown: a closed window has no toolbars and panels.
        """
        self._store.setValue("geometry", window.saveGeometry())
        self._store.setValue("panels", window.saveState(_LAYOUT))
        self._store.setValue("inner_panels", inner.saveState(_LAYOUT))
        self._store.sync()


def _bytes(value: Any) -> Optional[QByteArray]:
    return value if isinstance(value, QByteArray) else None
