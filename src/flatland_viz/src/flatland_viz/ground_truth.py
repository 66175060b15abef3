"""The status-line button for robots without a localiser, which are placed by ground truth."""

from typing import Any

from python_qt_binding.QtCore import QEvent, QObject, QSize
from python_qt_binding.QtWidgets import QAction, QMenu, QSizePolicy, QStatusBar, QToolButton

_HINT = (
    "Nothing publishes a transform from map to {frames}. This window draws the robots at their "
    "true poses; other nodes do not know where they are."
)
_PUBLISHED = "map \u2192 odom published"
_SHORT = "No map \u2192 odom"
_LONG = "No map \u2192 odom: robots drawn at true poses"


class _Button(QToolButton):
    """A button with a shorter text for narrow windows."""

    def __init__(self, name: str) -> None:
        super().__init__(objectName=name)
        self.setSizePolicy(QSizePolicy.Preferred, QSizePolicy.Fixed)
        self._texts = ("", "")

    def set_texts(self, long: str, short: str) -> None:
        self._texts = (long, short)
        self._choose()
        self.updateGeometry()

    def sizeHint(self) -> QSize:  # noqa: N802
        """The size with the long text."""
        return self._size_with(self._texts[0])

    def minimumSizeHint(self) -> QSize:  # noqa: N802
        """The size with the short text."""
        return self._size_with(self._texts[1])

    def resizeEvent(self, event: QEvent) -> None:  # noqa: N802
        """Shows the longest text that fits."""
        super().resizeEvent(event)
        self._choose()

    def _size_with(self, text: str) -> QSize:
        width = self.fontMetrics().horizontalAdvance
        return super().sizeHint() + QSize(width(text) - width(self.text()), 0)

    def _choose(self) -> None:
        long, short = self._texts
        self.setText(long if self.width() >= self.sizeHint().width() else short)


class GroundTruth(QObject):
    """A button in the status line while robots are placed by ground truth, with a menu.

    Args:
        display: rviz's display of the models (`flatland_viz/Models`).
        line: the status line.
        menu: menu that gets the action, too.
    """

    def __init__(self, display: Any, line: QStatusBar, menu: QMenu) -> None:
        super().__init__(line)
        self._frames = display.subProp("Placed Frames")
        self._publishes = display.subProp("Publish To TF")
        self._publish = QAction("Publish &map \u2192 odom", self, objectName="action_map_to_odom")
        self._publish.setCheckable(True)
        self._publish.setToolTip("for all nodes, until a localiser publishes it")
        self._publish.toggled.connect(self._set_published)
        self._button = _Button("status_ground_truth")
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
        if is_published:
            self._button.set_texts(_PUBLISHED, _PUBLISHED)
        else:
            self._button.set_texts(_LONG, _SHORT)
        self._button.setToolTip(_HINT.format(frames=frames))
