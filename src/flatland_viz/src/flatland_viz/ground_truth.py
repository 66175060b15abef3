"""Robots without a localiser: the window places them by ground truth, says so, and offers more."""

from typing import Any

from python_qt_binding.QtCore import QObject
from python_qt_binding.QtWidgets import QAction, QMenu, QStatusBar, QToolButton

_HINT = (
    "Nothing publishes a transform from map to {frames}. This window places the robots by their "
    "true poses; other nodes do not know where they are."
)


class GroundTruth(QObject):
    """A button in the status line while robots are placed by ground truth, with a menu.

    Args:
        display: rviz's display of the models (`flatland_viz/Models`).
        line: the status line.
        menu: gets the menu's action, too.
    """

    def __init__(self, display: Any, line: QStatusBar, menu: QMenu) -> None:
        super().__init__(line)
        self._frames = display.subProp("Placed Frames")
        self._publishes = display.subProp("Publish To TF")
        self._publish = QAction("Publish &map \u2192 odom", self, objectName="action_map_to_odom")
        self._publish.setCheckable(True)
        self._publish.setToolTip("for all nodes, until a localiser publishes it")
        self._publish.toggled.connect(self._set_published)
        self._button = QToolButton(objectName="status_ground_truth")
        self._button.setAutoRaise(True)
        self._button.setPopupMode(QToolButton.InstantPopup)
        choices = QMenu(self._button, objectName="menu_ground_truth")
        choices.addAction(self._publish)
        self._button.setMenu(choices)
        line.insertPermanentWidget(1, self._button)
        menu.addSeparator()
        menu.addAction(self._publish)
        self._frames.changed.connect(self._show)
        self._show()

    def _set_published(self, on: bool) -> None:
        self._publishes.setValue(on)
        self._show()

    def _show(self) -> None:
        frames = self._frames.getValue()
        is_published = self._publish.isChecked()
        self._publish.setEnabled(bool(frames) or is_published)
        self._button.setVisible(bool(frames))
        text = "map \u2192 odom published" if is_published else "Placed by ground truth"
        self._button.setText(text)
        self._button.setToolTip(_HINT.format(frames=frames))
