"""rviz's toolbar in the window: tooltips with keys, buttons of our own, most used first."""

from pathlib import Path
from typing import Any, Dict, List

import rospkg
from python_qt_binding.QtCore import Qt
from python_qt_binding.QtGui import QIcon
from python_qt_binding.QtWidgets import QAction, QToolBar

_SPACE = " "
_PAUSE = "flatland_viz/PauseSim"
_LEAST_USED = "flatland_viz/Measure"


def key_of(tool: Any) -> str:
    """The key of one of rviz's tools, as it is shown; empty if it has none."""
    key: str = tool.getShortcutKey()
    if key == _SPACE:
        return "Space"
    return key.upper() if key.isprintable() else ""


def icon(name: str) -> QIcon:
    """An icon of this package."""
    folder = Path(rospkg.RosPack().get_path("flatland_viz")) / "icons"
    return QIcon(str(folder / f"{name}.svg"))


class Toolbar:
    """Orders the toolbar; where there is no room, its last buttons go behind its ">>".

    First come the tools for the view and its models, with those that rviz adds later; then Pause,
    with our own buttons; and at last the least used one.

    Args:
        bar: rviz's toolbar.
        tools: tools of rviz, with a button each.
    """

    def __init__(self, bar: QToolBar, tools: List[Any]) -> None:
        self._bar = bar
        bar.setToolButtonStyle(Qt.ToolButtonTextBesideIcon)
        buttons = self.describe(tools)
        # rviz adds tools before a hidden action of its own, which stays in front of these buttons.
        bar.addSeparator()
        self._move_to_end(buttons[_PAUSE])
        self._least_used = bar.addSeparator()
        self._move_to_end(buttons[_LEAST_USED])

    def describe(self, tools: List[Any]) -> Dict[str, QAction]:
        """Sets the tooltips of tools' buttons; returns the buttons, by the tools' classes."""
        buttons = {}
        for tool in tools:
            for action in self._bar.actions():
                if action.text() == tool.getName():
                    self._describe(action, tool)
                    buttons[tool.getClassId()] = action
        return buttons

    def _move_to_end(self, action: QAction) -> None:
        self._bar.removeAction(action)
        self._bar.addAction(action)

    @staticmethod
    def _describe(action: QAction, tool: Any) -> None:
        key = key_of(tool)
        title = f"{action.text()} ({key})" if key else action.text()
        description = " ".join(tool.getDescription().split())
        action.setToolTip(f"<p><b>{title}</b><br>{description}</p>" if description else title)

    def add(self, action: QAction, icon_name: str, text: str) -> None:
        """Adds a button for an action of the menus.

        Args:
            action: an action of the menus.
            icon_name: name of a file in the folder `icons`, without its suffix.
            text: its name in the toolbar, which may be shorter than in the menu.
        """
        action.setIcon(icon(icon_name))
        action.setIconText(text)
        action.setIconVisibleInMenu(False)
        self._bar.insertAction(self._least_used, action)
