"""Labels of the panels and of the status line."""

from typing import Any

from python_qt_binding.QtCore import QEvent, Qt
from python_qt_binding.QtGui import QKeySequence, QTextDocument
from python_qt_binding.QtWidgets import QLabel, QSizePolicy


class ElidedLabel(QLabel):
    """A line that is elided, as plain text, if it does not fit; its tooltip then has all of it.

    It never widens its container.

    Args:
        place: where text is left out.
        properties: of the label.
    """

    def __init__(self, place: Qt.TextElideMode, **properties: Any) -> None:
        super().__init__(**properties)
        self.setSizePolicy(QSizePolicy.Ignored, QSizePolicy.Preferred)
        self._place = place
        self._line = ""

    def show_line(self, text: str) -> None:
        """Sets the line, as rich text."""
        if text != self._line:
            self._line = text
            self._fit()

    def resizeEvent(self, event: QEvent) -> None:  # noqa: N802
        """Shows as much as fits."""
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        document = QTextDocument()
        document.setDefaultFont(self.font())
        document.setDocumentMargin(0)
        document.setHtml(self._line)
        width, plain = self.contentsRect().width(), document.toPlainText()
        fits = document.idealWidth() <= width
        self.setTextFormat(Qt.RichText if fits else Qt.PlainText)
        self.setText(
            self._line if fits else self.fontMetrics().elidedText(plain, self._place, width)
        )
        self.setToolTip("" if fits else plain)


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
