"""rviz's toolbar in the window: tooltips with keys, buttons of our own, most used first."""

from pathlib import Path
from typing import Any, Dict, List, Optional

import rospkg
from python_qt_binding.QtCore import QEvent, QObject, Qt
from python_qt_binding.QtGui import QIcon
from python_qt_binding.QtWidgets import QAction, QToolBar

_SPACE = " "
_PAUSE = "flatland_viz/PauseSim"
_LEAST_USED = ("flatland_viz/ChangeRate", "flatland_viz/Measure")
"""Tools at the end of the toolbar: where there is no room, they go behind its ">>"."""


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


class Toolbar(QObject):
    """Orders the toolbar, and shows icons alone where there is no room for their names.

    First come the tools for the view and its models, with those that rviz adds later; then Pause,
    with our own buttons; and at last the least used ones.

    Args:
        bar: rviz's toolbar.
        tools: tools of rviz, with a button each.
    """

    def __init__(self, bar: QToolBar, tools: List[Any]) -> None:
        super().__init__(bar)
        self._bar = bar
        self._is_fitting = False
        self._full_width = 0
        self._order(self.describe(tools))
        bar.installEventFilter(self)

    def describe(self, tools: List[Any]) -> Dict[str, QAction]:
        """Sets the tooltips of tools' buttons; returns the buttons, by the tools' classes."""
        buttons = {}
        for tool in tools:
            for action in self._bar.actions():
                if action.text() == tool.getName():
                    self._describe(action, tool)
                    buttons[tool.getClassId()] = action
        return buttons

    def _order(self, buttons: Dict[str, QAction]) -> None:
        """Moves the buttons; `buttons` are those of tools, by their classes."""
        bar = self._bar
        # rviz adds tools before a hidden action of its own, which stays in front of these buttons.
        bar.addSeparator()
        self._pause = buttons.get(_PAUSE)
        self._move_to_end(self._pause)
        self._least_used = bar.addSeparator()
        for kind in _LEAST_USED:
            self._move_to_end(buttons.get(kind))

    def _move_to_end(self, action: Optional[QAction]) -> None:
        if action is not None:
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

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        """Fits the toolbar to its width, and to names that have changed."""
        if event.type() in (QEvent.ActionAdded, QEvent.ActionRemoved):
            self._bar.setToolButtonStyle(Qt.ToolButtonTextBesideIcon)  # its width is measured again
        if event.type() in (QEvent.Resize, QEvent.LayoutRequest) and not self._is_fitting:
            self._is_fitting = True
            self._fit()
            self._is_fitting = False
        return False

    def _fit(self) -> None:
        self._keep_width()
        if self._bar.toolButtonStyle() != Qt.ToolButtonIconOnly:
            self._full_width = self._bar.layout().sizeHint().width()
        is_narrow = self._bar.width() < self._full_width
        style = Qt.ToolButtonIconOnly if is_narrow else Qt.ToolButtonTextBesideIcon
        if style != self._bar.toolButtonStyle():
            self._bar.setToolButtonStyle(style)
            self._keep_width()

    def _keep_width(self) -> None:
        """Gives Pause the width of Resume, so that the other buttons stay where they are."""
        button = self._bar.widgetForAction(self._pause) if self._pause else None
        if button is None:
            return
        widths = [
            button.fontMetrics().size(Qt.TextShowMnemonic, text).width()
            for text in ("Resume", button.text())
        ]
        wider = widths[0] - widths[1]
        has_text = self._bar.toolButtonStyle() == Qt.ToolButtonTextBesideIcon
        button.setMinimumWidth(button.sizeHint().width() + max(0, wider) if has_text else 0)
