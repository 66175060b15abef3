"""Labels of the panels."""

from typing import Any

from python_qt_binding.QtCore import QEvent, Qt
from python_qt_binding.QtGui import QKeySequence, QPainter
from python_qt_binding.QtWidgets import QLabel, QSizePolicy


class ElidedLabel(QLabel):
    """A line that is elided in the middle if it does not fit; its tooltip has all of it.

    It never widens its container.
    """

    def __init__(self, **properties: Any) -> None:
        super().__init__(**properties)
        self.setSizePolicy(QSizePolicy.Ignored, QSizePolicy.Preferred)

    def setText(self, text: str) -> None:  # noqa: N802
        """Sets the line."""
        super().setText(text)
        self.setToolTip(text)

    @property
    def shown_text(self) -> str:
        """The visible text."""
        metrics = self.fontMetrics()
        return str(metrics.elidedText(self.text(), Qt.ElideMiddle, self.contentsRect().width()))

    def paintEvent(self, event: QEvent) -> None:  # noqa: N802
        """Draws the line."""
        QPainter(self).drawText(self.contentsRect(), int(self.alignment()), self.shown_text)


class SelectableLabel(QLabel):
    """A label with text to select and copy, also where Ctrl+C is the key of an action."""

    def __init__(self, **properties: Any) -> None:
        super().__init__(**properties)
        self.setTextInteractionFlags(Qt.TextSelectableByMouse)

    def event(self, event: QEvent) -> bool:
        """Takes the key for itself while text is selected."""
        is_key = event.type() == QEvent.ShortcutOverride and event.matches(QKeySequence.Copy)
        if is_key and self.hasSelectedText():
            event.accept()
            return True
        return bool(super().event(event))
